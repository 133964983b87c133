// SPDX-License-Identifier: GPL-2.0-or-later
//
// fix floe/integrate: moves the elements. One pass over them per step applies contact forces and all
// external forces, advances velocity, position, spin and orientation, and keeps the budgets.
//
// The scheme is the leapfrog form of velocity Verlet: the velocity of a state belongs to half a step
// before its position. Forces are evaluated at the stored positions and velocities and nowhere
// else, so a state that was written and read back continues with the same numbers.
#ifndef LMP_FIX_FLOE_INTEGRATE_H
#define LMP_FIX_FLOE_INTEGRATE_H

#include <cstdio>
#include <string>
#include <vector>

#include "body.h"
#include "drag.h"
#include "fix.h"
#include "forces.h"
#include "forcing.h"
#include "large_pages.h"
#include "ledger.h"

namespace floe {
class PairFloe;
}

namespace LAMMPS_NS {

class FixFloeIntegrate : public Fix {
 public:
  static constexpr int fixed_type = 2;  // elements of this type never move
  static constexpr int impulse_numbers = 4;
  // That an element takes along to another rank or to a restart file.
  static constexpr int own_numbers = 6 + impulse_numbers;

  FixFloeIntegrate(class LAMMPS *, int, char **);
  ~FixFloeIntegrate() override;
  int setmask() override;
  void init() override;
  void setup(int) override;
  void initial_integrate(int) override;
  void post_integrate() override;
  void setup_pre_exchange() override;
  void pre_exchange() override;
  void post_run() override;
  int modify_param(int, char **) override;

  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_border(int, int *, double *) override;
  int unpack_border(int, int, double *) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_comm(int, int *, double *, int, int *) override;
  void unpack_comm(int, int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  void write_restart(FILE *) override;
  void restart(char *) override;
  double compute_vector(int) override;
  double memory_usage() override;

  bool has_run() const { return has_run_; }
  void set_orientation(int i, double angle);
  // Hands the orientations of this rank's elements to their ghosts, on all ranks.
  void send_orientations();

  // Notes that the bond between elements i and j has come to the end of the neighbours' reach.
  void fault_at(int i, int j);

  double *thickness;    // m, of elements and ghosts
  double *cover;        // share of an element that ice covers, of elements and ghosts
  double *ice_area;     // m2
  double *theta;        // rad
  double *ridged_area;  // m2, turned into ridges since the element was made
  double *bonds_made;   // how many bonds the element was given
  double **impulse;     // N s, of wind (x, y) and of the ocean (x, y), since the element was made
  double **turn;  // cosine and sine of theta, of elements and ghosts, as current as velocities

  // What the pair style reads and adds up, of elements and ghosts: valid from one evaluation of the
  // pairs to the next, in LIGGGHTS' order. The parts that damping has in the loads are there with
  // exact_losses only.
  floe::LongArray<floe::Body> bodies;
  floe::LongArray<floe::Load> loads, damped_bond, damped_contact;
  bool loads_cleared;     // those of this rank's own elements, by the integrator
  floe::PairFloe *pairs;  // null with another pair style
  // Asked for with the keyword `fused` and nothing else sees forces or moves elements: the integrator
  // takes the loads as they are and writes the bodies of the next step, and LIGGGHTS' arrays of
  // forces are not touched.
  bool fused;
  void write_forces();  // into LIGGGHTS' arrays, for others to read
  // Fused, velocities, spins and orientations lie in the bodies alone, but for elements that other
  // ranks see, until a run ends, lists are made anew or something is printed.
  void write_velocities();
  // Energy (J) that damping takes in the half of a step that leads from the present velocities, which
  // belong to half a step ago, to those at the time of the positions.
  floe::DampingWork damping_to_now() const;

  bool use_orientation;  // false where no bond needs cosine and sine

  floe::DriftLaw law;
  floe::Forces forces;
  floe::ForcingGrid forcing;
  double start_time;           // s, time of step 0 on the forcing's axis
  double step_length() const;  // s
  // Of all steps so far, whatever their lengths were, s.
  double elapsed() const { return elapsed_; }
  floe::Ledger ledger;
  // Of the further forces; their sums come last of all: scripts name sums by their numbers.
  floe::Forces::Ledger force_ledger;
  floe::Fault fault;

 private:
  template <bool External>
  void advance();
  template <bool External, bool Fused>
  void advance_some(int first, int last, const floe::ForcingTime &, floe::Ledger &);
  void count_damping(int i, floe::Vec2 u, floe::Vec2 u_new, double spin, double new_spin,
                     floe::Ledger &) const;
  void parse(int first, int narg, char **arg);
  void note_fault(int i, int kind, int partner, double speed);
  void freeze(int i, int kind, double speed);
  void check_others();
  void check_listed() const;
  void check_plane();
  void check_kept();
  void check_period() const;
  // Wind and water from variables of the script, evaluated at each step.
  void find_variables();
  void sample_variables();
  void take_variables(int i, floe::ForcingSample &here) const;
  bool output_now() const;
  void write_velocity(int i);
  void write_sent();
  bool ask_fused;        // by keyword
  bool arrays_current_;  // velocities, spins and orientations of LIGGGHTS' arrays
  bool has_run_ = false;
  bool known_ = false;         // histories of pairs belong to what this fix holds of the elements
  double elapsed_ = 0.0;       // s
  int *kept_ids_;              // of elements when the last run ended; 0 for those that came since
  bool between_runs_ = false;  // commands may change the elements
  bool first_kick;             // no step was made since the elements were set
  bool stop_at_fault;  // end the run; else keep the element where it is and let the driver ask
  double default_thickness, default_cover, default_ice_area;
  std::string variable_names_[4];  // of wind u v and ocean u v; empty: a number
  int variables_[4] = {-1, -1, -1, -1};
  bool with_variables_ = false;
  std::vector<double> sampled_;  // four of each element
  std::vector<double> sums_;     // of all ranks, at an evaluation of the pairs
  long long sums_at_ = -1;
};

}  // namespace LAMMPS_NS

#endif
