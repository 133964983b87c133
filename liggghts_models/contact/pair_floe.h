// SPDX-License-Identifier: GPL-2.0-or-later
//
// pair_style gran model floe: forces between elements of sea ice. LIGGGHTS hands over neighbour and
// history lists; the loop over pairs is ours, so that it works in two dimensions and is compiled once
// for each set of effects, without virtual calls or switches inside.
#ifndef FLOE_CONTACT_PAIR_FLOE_H
#define FLOE_CONTACT_PAIR_FLOE_H

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "body.h"
#include "bond.h"
#include "contact.h"
#include "granular_pair_style.h"
#include "laws.h"
#include "losses.h"
#include "pair_state.h"
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
  PairFloe(LAMMPS_NS::LAMMPS *lmp, LAMMPS_NS::PairGran *pair, std::int64_t hash)
      : Pointers(lmp), pair_(pair), hash_(hash) {}
  ~PairFloe() override;

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
    RidgeForce limit = ridging_force(r);
    limit.slope += lead_slope(ridge, r, span, limit.force);
    return ridge_closing(limit, stiffness, span, overlap, r);
  }
  double cover_between(int lo, int hi) const;
  // Share of a contact's closed area that element i gives; a fixed one gives nothing.
  double share_of(int i, int j) const;
  bool touches(int i, int j) const;  // whether two elements may be in contact
  int lower(int i, int j) const;     // that of two elements which has the lower id
  double reduced_mass(int i, int j) const;
  ContactSide side_of(int i) const;
  // Of a contact of two elements, lower id first.
  ContactConstants contact_of(int lo, int hi) const;
  // The records are no longer valid: LIGGGHTS' history holds from now on.
  void forget_records() { stale_ = true; }
  // The same after others than this class changed the history in LIGGGHTS' lists.
  void history_changed();
  // Writes what the steps changed into that history, for others to read.
  void write_history();
  // The same, and from the lists to the elements, which take it along when the lists are gone.
  void keep_history();
  // Whether the lists of neighbours belong to the elements as they are.
  bool lists_hold() const;
  // Changes when forces or history did.
  long long evaluations() const { return evaluations_; }

  // All pairs with a force or a history, as the last evaluation left them.
  void each_pair(const std::function<void(const PairState &)> &visit);
  BondState bond_state(int number);
  bool log_breakages = false;
  std::vector<Breakage> breakages;  // of this rank, since they were last taken away
  // The same before LIGGGHTS makes new lists; what this class keeps is no longer valid then.
  void lists_change();

  bool bonds = false, friction = true, ridging = false, kovacs_sodhi = false;
  bool fixed_contacts = true;  // else fixed elements only bond: walls stand where they do
  bool deterministic = false;  // sums per element that do not depend on order and ranks
  bool exact_losses = false;   // losses of damping to second order in the step
  double compressive = 0.0;    // Pa, where it is constant
  double reach = 1.0;          // neighbours are kept up to this multiple of the sum of radii
  BondMaterial bond{};
  ContactMaterial contact{};
  RidgeMaterial ridge{};

 private:
  bool gather_bodies();
  void clear_loads(bool current);
  void make_current();
  // How often LIGGGHTS has made lists, and the step of the last: changes whenever the pages of history
  // may be others.
  std::pair<std::int64_t, std::int64_t> lists_made() const;
  // Ends the run where records of other lists than the present ones would be used.
  void check_lists() const;
  BondShape shape_of(int number);
  BondConstants constants_at(int number);
  BondPose pose_of(int number);
  void tally(LAMMPS_NS::PairGran *);
  void list_pairs(LAMMPS_NS::PairGran *);
  void note_breakage(int number, BreakageMode, const BondShape &before, const BondLine &line,
                     double energy);
  void copy_to_elements();
  void read_history();
  BondConstants constants_of(const BondShape &, int i, int j) const;
  void start_contact(int number);
  void forget_contact(int number);
  bool across_gap(int number, double distance, double sum, bool advance);
  void evaluate();
  template <typename Law, bool Exact>
  void evaluate_bonds_of(Losses &);
  template <typename Law, bool Exact>
  void evaluate_contacts_of(ContactSums &);
  template <bool Exact>
  void evaluate_exactly_or_not();
  template <typename Terms>
  void loop_contacts(ContactSums &);
  template <typename Law, bool Exact>
  void bond_alone(int number, Losses &);
  double limit2() const { return 0.998 * reach * reach; }
  void fold_exact_sums();
  // A bond that broke goes on as a contact: its force (N) and energy (J) in compression at that moment.
  // Returns the elastic energy of the contact, J, and the force that it starts with, N.
  struct Taken {
    double energy = 0.0, push = 0.0;
  };
  Taken take_over(int number, double overlap, double force, double energy);

  LAMMPS_NS::PairGran *pair_;
  BondRecords bonded_;
  ContactRecords contacts_;
  std::vector<int> odd_;
  bool advance_ = false;  // the step that is evaluated changes the history
  bool stale_ = true;     // the records: LIGGGHTS' history holds
  std::pair<std::int64_t, std::int64_t> read_from_;  // lists_made() of the records
  int listed_ = -1;         // elements of this rank when the lists were last used; -1: not valid
  int page_ = 0, one_ = 0;  // of neigh_modify, when history was first kept
  long long evaluations_ = 0;
  std::string words_;  // of the command, for restart files
  LAMMPS_NS::FixFloeIntegrate *fix_ = nullptr;
  std::int64_t hash_;
};

}  // namespace floe

#endif
