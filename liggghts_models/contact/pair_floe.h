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
#include "contact.h"
#include "granular_pair_style.h"
#include "losses.h"
#include "pointers.h"
#include "records.h"
#include "ridge.h"

namespace LAMMPS_NS {
class FixFloeIntegrate;
}

namespace floe {

struct ContactSums;

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

  PairSums sums(LAMMPS_NS::PairGran *);
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
  int lower(int i, int j) const;  // that of two elements which has the lower id
  double reduced_mass(int i, int j) const;
  // The history of LIGGGHTS' lists was changed by others than this class: it holds from now on.
  void bonds_changed() { stale_ = true; }
  // Writes what the steps changed into that history, for others to read.
  void write_history();
  // The same before LIGGGHTS makes new lists; what this class keeps is no longer valid then.
  void lists_change();

  bool bonds = false, friction = true, ridging = false, kovacs_sodhi = false;
  bool deterministic = false;  // sums per element that do not depend on order and ranks
  bool exact_losses = false;   // losses of damping to second order in the step
  double compressive = 0.0;    // Pa, where it is constant
  double reach = 1.0;          // neighbours are kept up to this multiple of the sum of radii
  BondMaterial bond{};
  ContactMaterial contact{};
  RidgeMaterial ridge{};

 private:
  void gather();
  void read_history();
  BondConstants constants_of(const BondShape &, int i, int j) const;
  void start_contact(int number);
  void forget_contact(int number);
  bool across_gap(int number, double distance, double sum, bool advance);
  void evaluate();
  template <bool Exact>
  void evaluate_exactly_or_not();
  template <typename Terms>
  void loop_contacts(ContactSums &);
  template <bool Exact>
  void bond_alone(int number, Losses &);
  double limit2() const { return 0.998 * reach * reach; }
  void fold_exact_sums();
  // A bond that broke goes on as a contact: its force (N) and energy (J) in compression at that moment.
  // Returns the elastic energy of the contact, J, and the force that it starts with, N.
  struct Taken {
    double energy = 0.0, push = 0.0;
  };
  Taken take_over(int number, double overlap, double force, double energy);

  LAMMPS_NS::PairGran *pair_ = nullptr;
  BondRecords bonded_;
  ContactRecords contacts_;
  std::vector<int> odd_;
  bool advance_ = false;  // the step that is evaluated changes the history
  bool stale_ = true;     // the records: LIGGGHTS' history holds
  LAMMPS_NS::FixFloeIntegrate *fix_ = nullptr;
  std::int64_t hash_;
};

}  // namespace floe

#endif
