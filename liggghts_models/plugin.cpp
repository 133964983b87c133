// SPDX-License-Identifier: GPL-2.0-or-later
//
// Registration in the stock LIGGGHTS library. This is the one file that reaches for members that
// LIGGGHTS keeps private; an explicit template instantiation may name them, which makes it legal C++.
#include "plugin.h"

#include <map>
#include <string>

// contact_models.h relies on these without including them.
#include "comm.h"
#include "error.h"
#include "force.h"

#include "bond_command.h"
#include "compute_floe.h"
#include "contact_models.h"
#include "displace_command.h"
#include "fix_floe_breakage.h"
#include "fix_floe_integrate.h"
#include "fix_floe_walls.h"
#include "granular_pair_style.h"
#include "input.h"
#include "integrate.h"
#include "lammps.h"
#include "modify.h"
#include "pair_floe.h"
#include "pair_gran_proxy.h"
#include "update.h"
#include "wall_floe.h"

using namespace LAMMPS_NS;

namespace floe {

namespace {

constexpr int normal_model_id = 41;  // below 64 and not used by any stock model

template <typename Tag, typename Tag::type Member>
struct Expose {
  friend typename Tag::type get(Tag) { return Member; }
};

using FixCreator = Fix *(*)(LAMMPS *, int, char **);
struct FixMap {
  using type = std::map<std::string, FixCreator> *Modify::*;
  friend type get(FixMap);
};
template struct Expose<FixMap, &Modify::fix_map>;

using ComputeCreator = Compute *(*)(LAMMPS *, int, int, char **);
struct ComputeMap {
  using type = std::map<std::string, ComputeCreator> *Modify::*;
  friend type get(ComputeMap);
};
template struct Expose<ComputeMap, &Modify::compute_map>;

using Command = void (*)(LAMMPS *, int, char **);
struct CommandMap {
  using type = std::map<std::string, Command> *Input::*;
  friend type get(CommandMap);
};
template struct Expose<CommandMap, &Input::command_map>;

struct PairImplementation {
  using type = LIGGGHTS::PairStyles::IGranularPairStyle *PairGranProxy::*;
  friend type get(PairImplementation);
};
template struct Expose<PairImplementation, &PairGranProxy::impl>;

struct ForceClear {
  using type = int Integrate::*;
  friend type get(ForceClear);
};
template struct Expose<ForceClear, &Integrate::external_force_clear>;

struct Swaps {
  using type = int Comm::*;
  friend type get(Swaps);
};
template struct Expose<Swaps, &Comm::nswap>;

struct SentCounts {
  using type = int *Comm::*;
  friend type get(SentCounts);
};
template struct Expose<SentCounts, &Comm::sendnum>;

struct SentLists {
  using type = int **Comm::*;
  friend type get(SentLists);
};
template struct Expose<SentLists, &Comm::sendlist>;

LIGGGHTS::PairStyles::IGranularPairStyle *create_pair(LAMMPS *lmp, PairGran *pair,
                                                      std::int64_t hash) {
  return new PairFloe(lmp, pair, hash);
}

LIGGGHTS::Walls::IGranularWall *create_wall(LAMMPS *lmp, FixWallGran *, std::int64_t) {
  return new WallFloe(lmp);
}

template <typename Made>
void run_command(LAMMPS *lmp, int narg, char **arg) {
  Made(lmp).command(narg, arg);
}

template <typename Made>
Fix *create_fix(LAMMPS *lmp, int narg, char **arg) {
  return new Made(lmp, narg, arg);
}

template <typename Made>
Compute *create_compute(LAMMPS *lmp, int iarg, int narg, char **arg) {
  return new Made(lmp, iarg, narg, arg);
}

void register_pair() {
  auto &models = LIGGGHTS::ContactModels::Factory::instance();
  if (models.getNormalModelId("floe") == normal_model_id) return;
  models.addNormalModel("floe", normal_model_id);
  constexpr std::int64_t hash = LIGGGHTS::ContactModels::GranStyle<normal_model_id>::HASHCODE;
  LIGGGHTS::PairStyles::Factory::instance().addStyle("gran", hash, create_pair);
  LIGGGHTS::Walls::Factory::instance().addStyle("gran", hash, create_wall);
}

}  // namespace

void register_models(LAMMPS *lmp) {
  register_pair();
  auto &fixes = *(lmp->modify->*get(FixMap()));
  fixes["floe/integrate"] = create_fix<FixFloeIntegrate>;
  fixes["floe/breakage"] = create_fix<FixFloeBreakage>;
  fixes["floe/walls"] = create_fix<FixFloeWalls>;
  auto &computes = *(lmp->modify->*get(ComputeMap()));
  computes["floe/atom"] = create_compute<ComputeFloeAtom>;
  computes["floe/bond/local"] = create_compute<ComputeFloeBondLocal>;
  auto &commands = *(lmp->input->*get(CommandMap()));
  commands["floe_bonds"] = run_command<BondCommand>;
  commands["displace_atoms"] = run_command<DisplaceCommand>;
}

void clear_forces(LAMMPS *lmp, bool wanted) {
  lmp->update->integrate->*get(ForceClear()) = !wanted;
}

void each_sent(Comm *comm, const std::function<void(int)> &visit) {
  const int *count = comm->*get(SentCounts());
  const int *const *list = comm->*get(SentLists());
  for (int swap = 0; swap < comm->*get(Swaps()); ++swap) {
    for (int k = 0; k < count[swap]; ++k) visit(list[swap][k]);
  }
}

Parts find_parts(LAMMPS *lmp) {
  Parts out;
  auto *proxy = dynamic_cast<PairGranProxy *>(lmp->force->pair);
  if (proxy) {
    out.pair = proxy;
    out.floe = dynamic_cast<PairFloe *>(proxy->*get(PairImplementation()));
  }
  out.fix = dynamic_cast<FixFloeIntegrate *>(lmp->modify->find_fix_style("floe/integrate", 0));
  out.walls = dynamic_cast<FixFloeWalls *>(lmp->modify->find_fix_style("floe/walls", 0));
  return out;
}

}  // namespace floe
