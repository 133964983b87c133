// SPDX-License-Identifier: GPL-2.0-or-later
//
// fix floe/walls: elements against walls of straight faces in the plane of the ice (laws/wall.h), as
// scenes have them. Forces follow contact/wall_law.h.
//
// LIGGGHTS' own walls (fix wall/gran, contact/wall_floe.h) are for input scripts: their planes cannot
// move along their normal, their meshes are cut in bins that a wall as long as the box does not fit,
// and their history cannot be put in. Here the history of a contact is named by element and face, so it
// goes to the state and back, on any number of ranks.
#ifndef LMP_FIX_FLOE_WALLS_H
#define LMP_FIX_FLOE_WALLS_H

#include <functional>
#include <unordered_map>
#include <vector>

#include "fix.h"
#include "wall.h"
#include "wall_law.h"

namespace LAMMPS_NS {

class FixFloeWalls : public Fix {
 public:
  struct Contact {
    int face;
    floe::WallHistory history;
  };
  struct Sums {
    double elastic_wall = 0.0, work_wall = 0.0, wall_contacts = 0.0;  // J, J, count
  };

  FixFloeWalls(class LAMMPS *, int, char **);
  ~FixFloeWalls() override;
  int setmask() override;
  void init() override;
  void setup_pre_force(int) override;
  void setup(int) override;
  void initial_integrate(int) override;
  void setup_pre_exchange() override;
  void pre_exchange() override;
  void pre_force(int) override;
  void post_force(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  double memory_usage() override;

  // Replaces all walls; their contacts are forgotten.
  void set_walls(std::vector<floe::WallFace> faces, int walls);
  // Contacts of this rank's elements, by tag. Take effect at the next setup.
  void put(int tag, const Contact &contact) { parked_[tag].push_back(contact); }
  template <typename Visit>
  void each(Visit visit) const;  // (tag, contact)

  Sums sums(double &max_overlap);
  // Calls visit(element, arm from its centre to the wall, force on it) for each contact as it is now.
  void each_force(const std::function<void(int, floe::Vec2, floe::Vec2)> &visit) const;
  // On the ice, x and y of each wall: N s since the start, N now.
  const std::vector<double> &impulses() const { return impulse_; }
  const std::vector<double> &forces() const { return force_; }

 private:
  // An element near walls: its candidate faces in candidates_, and its contacts.
  struct Near {
    int i, first, count;
    std::vector<Contact> contacts;
  };
  struct Group {
    floe::Vec2 low, high;  // box around some faces of one wall, at time 0
    int first, count;
  };

  floe::Vec2 moved(const floe::WallFace &face) const;
  double time() const;
  void build();
  template <typename Visit>
  void each_contact(const Near &near, Visit visit) const;
  void advance(Near &near, double step);
  const Contact *past(const Near &near, int face, const std::vector<int> &now) const;

  floe::WallLaw law_{nullptr, nullptr};
  std::vector<floe::WallFace> faces_;
  std::vector<Group> groups_;
  std::vector<Near> near_;
  std::vector<int> candidates_;
  std::unordered_map<int, std::vector<Contact>> parked_;  // while elements change their places
  std::vector<double> force_, impulse_;
  double work_ = 0.0, fastest_ = 0.0, built_at_ = 0.0;
  bool stale_ = true;
};

template <typename Visit>
void FixFloeWalls::each(Visit visit) const {
  for (const Near &near : near_) {
    for (const Contact &contact : near.contacts) visit(near.i, contact);
  }
}

}  // namespace LAMMPS_NS

#endif
