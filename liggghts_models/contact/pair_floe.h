// SPDX-License-Identifier: GPL-2.0-or-later
//
// pair_style gran model floe: forces between elements of sea ice. LIGGGHTS hands over neighbour and
// history lists; the loop over pairs is ours, so that it works in two dimensions and is compiled once
// for each set of effects, without virtual calls or switches inside.
#ifndef FLOE_CONTACT_PAIR_FLOE_H
#define FLOE_CONTACT_PAIR_FLOE_H

#include <cstdint>
#include <string>
#include <vector>

#include "body.h"
#include "bond.h"
#include "bond_batch.h"
#include "contact.h"
#include "granular_pair_style.h"
#include "pointers.h"
#include "ridge.h"

namespace LAMMPS_NS {
class FixFloeIntegrate;
}

namespace floe {

struct Losses;

// Energy (J) and counts of the present pairs of one rank.
struct PairSums {
  double elastic_bond = 0.0, elastic_contact = 0.0;
  double bonds = 0.0, contacts = 0.0, max_overlap = 0.0;
};

class PairFloe : public LIGGGHTS::PairStyles::IGranularPairStyle, private LAMMPS_NS::Pointers {
 public:
  PairFloe(LAMMPS_NS::LAMMPS *lmp, std::int64_t hash) : Pointers(lmp), hash_(hash) {}

  void settings(int narg, char **arg, LIGGGHTS::IContactHistorySetup *setup) override;
  void init_granular() override;
  void write_restart_settings(FILE *) override;
  void read_restart_settings(FILE *, std::int64_t) override;
  void compute_force(LAMMPS_NS::PairGran *, int eflag, int vflag, int addflag) override;
  int get_history_offset(const std::string name) override;
  double stressStrainExponent() override { return 1.0; }
  std::int64_t hashcode() override { return hash_; }
  bool contact_match(const std::string type, const std::string model) override {
    return type == "normal" && model == "floe";
  }

  PairSums sums(LAMMPS_NS::PairGran *) const;
  double compressive_strength(double thickness) const {
    return kovacs_sodhi ? kovacs_sodhi_strength(thickness) : compressive;
  }
  int history_size() const;
  RidgeForce ridging_force(const Ridge &r) const {
    return ridge_force(ridge, compressive_strength(r.thickness), r);
  }
  double ridging_limit(const Ridge &r) const { return r.length * ridging_force(r).force; }
  double close_ridge(double stiffness, double span, double overlap, Ridge &r) const {
    return ridge_closing(ridging_force(r), stiffness, span, overlap, r);
  }
  // Share of a contact's closed area that element i gives; a fixed one gives nothing.
  double share_of(int i, int j) const;
  // Fills the slots of a bond that follow from its others and from its elements i and j.
  void finish_bond(double *history, int i, int j) const;
  void finish_contact(double *history, int i, int j) const;  // and of a contact
  void bonds_changed() { stale_ = true; }  // by others than this class, in the neighbour lists

  bool bonds = false, friction = true, ridging = false, kovacs_sodhi = false;
  double compressive = 0.0;  // Pa, where it is constant
  double reach = 1.0;        // neighbours are kept up to this multiple of the sum of radii
  BondMaterial bond{};
  ContactMaterial contact{};
  RidgeMaterial ridge{};

 private:
  template <bool Bonds, bool Friction, bool Ridging>
  void loop(LAMMPS_NS::PairGran *);
  template <bool Friction>
  [[gnu::noinline]] void loop_contacts(LAMMPS_NS::PairGran *);
  template <bool Ridging>
  void bond_alone(const ListedBond &, int size, bool advance, Losses &);
  double limit2() const { return 0.998 * reach * reach; }
  void list_bonds(LAMMPS_NS::PairGran *);
  template <bool Friction>
  void choose_loop(LAMMPS_NS::PairGran *);
  void gather();
  void scatter();
  void scatter_ridged();
  // Turns the history of a bond that broke into that of the contact that goes on: its force (N) and
  // energy (J) in compression at that moment. Returns the elastic energy of the contact, J.
  double take_over(int &flag, double *history, int i, int j, double overlap, double force,
                   double energy) const;
  double reduced_mass(int i, int j) const;
  std::vector<Body> bodies_;  // of elements and ghosts
  std::vector<Load> loads_;
  BondBatch batch_;
  std::vector<int> rims_;  // elements with neighbours that they are not bonded to
  bool stale_ = true;      // the lists of bonds
  LAMMPS_NS::FixFloeIntegrate *fix_ = nullptr;
  std::int64_t hash_;
};

}  // namespace floe

#endif
