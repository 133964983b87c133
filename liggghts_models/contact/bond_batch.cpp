// SPDX-License-Identifier: GPL-2.0-or-later
#include "bond_batch.h"

#include <cstddef>

#include "history.h"
#include "lane_sums.h"

namespace floe {

namespace {

template <typename P>
struct BatchState {
  BondShapeOf<P> shape;
  BondConstantsOf<P> constants;
  BondPoseOf<P> pose;
  P radii;
};

// Histories and elements of one bond per lane, as packs.
template <typename P, int Width>
FLOE_INLINE BatchState<P> gather(const ListedBond *bonds, const Body *bodies) {
  static_assert(slot::span == 0 && slot::lo_ax == 3 && slot::bond_thickness == 11 &&
                    slot::bond_length == 12 && slot::bond_squeeze == 15 && slot::bond_size == 16,
                "the order in which columns are taken");
  const double *row[Width], *lo[Width], *hi[Width];
  for (int k = 0; k < Width; ++k) {
    row[k] = bonds[k].history;
    lo[k] = &bodies[bonds[k].lo].x;
    hi[k] = &bodies[bonds[k].hi].x;
  }
  P a[4], b[4], c[4], d[4];
  BatchState<P> out;
  columns(row, 0, a);
  columns(row, 4, b);
  columns(row, 8, c);
  columns(row, 12, d);
  out.shape = {{a[3], b[0]}, {b[1], b[2]}, {b[3], c[0]}, {c[1], c[2]}, a[0], c[3], a[1], a[2]};
  out.constants = {d[0], d[1], d[2], d[3]};
  differences(hi, lo, a);
  columns(lo, 4, c);
  columns(hi, 4, d);
  out.pose = {{a[0], a[1]}, {c[1], c[2]}, {d[1], d[2]}, {a[2], a[3]}, c[0], d[0]};
  out.radii = c[3] + d[3];
  return out;
}

struct Task {
  const BondMaterial material;
  const double limit2;
  const bool check;
  const Body *const bodies;
  Load *const loads;
};

template <typename P, int Width, bool Whole>
FLOE_INLINE void evaluate_pack(const Task &t, const ListedBond *bonds, int count, P &sum,
                               std::vector<ListedBond> &odd) {
  const BatchState<P> s = gather<P, Width>(bonds, t.bodies);
  const BondLineOf<P> line = bond_line(s.shape, s.pose);
  P power;
  const PairForceOf<P> force = bond_force(t.material, s.constants, s.shape, line, s.pose, power);
  const P none{};
  auto holds = none == none;
  if (t.check) {
    const auto limits = bond_limits(t.material, s.constants, line);
    const auto range = bond_range(line, s.shape);
    const P square = s.pose.d.x * s.pose.d.x + s.pose.d.y * s.pose.d.y;
    holds = (range.least >= limits.least) & (range.most <= limits.most) &
            (square <= t.limit2 * s.radii * s.radii);
  }
  double *lo[Width], *hi[Width];
  P share;
  for (int k = 0; k < Width; ++k) {
    lo[k] = &t.loads[bonds[k].lo].fx;
    hi[k] = &t.loads[bonds[k].hi].fx;
    share[k] = bonds[k].share;
  }
  if (Whole && all(holds)) {
    sum += share * power;
  } else {
    Load nowhere{};
    for (int k = 0; k < Width; ++k) {
      if (k < count && holds[k]) continue;
      lo[k] = hi[k] = &nowhere.fx;
      power[k] = 0.0;
      if (k < count) odd.push_back(bonds[k]);
    }
    sum += share * power;
  }
  add_rows(lo, {force.f.x, force.f.y, force.torque_lo, none});
  add_rows(hi, {-force.f.x, -force.f.y, force.torque_hi, none});
}

template <typename P, int Width>
FLOE_INLINE double evaluate_all(const Task &t, const std::vector<ListedBond> &bonds,
                                std::vector<ListedBond> &odd) {
  constexpr int parts = 4 / Width;
  P part[parts] = {};
  const int count = static_cast<int>(bonds.size()), whole = count / 4 * 4;
  for (int first = 0; first < whole; first += 4) {
    for (int k = 0; k < parts; ++k) {
      evaluate_pack<P, Width, true>(t, bonds.data() + first + k * Width, Width, part[k], odd);
    }
  }
  if (whole < count) {
    ListedBond last[4];
    for (int k = 0; k < 4; ++k) last[k] = bonds[whole + k < count ? whole + k : whole];
    for (int k = 0; k < parts; ++k) {
      evaluate_pack<P, Width, false>(t, last + k * Width, count - whole - k * Width, part[k], odd);
    }
  }
  LaneSums sums;
  for (int k = 0; k < parts; ++k) sums.add(k * Width, part[k]);
  return sums.total();
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] double evaluate_wide(const Task &t, const std::vector<ListedBond> &bonds,
                                             std::vector<ListedBond> &odd) {
  return evaluate_all<Pack4, 4>(t, bonds, odd);
}
#endif

}  // namespace

double BondBatch::evaluate(const BondMaterial &material, double limit2, bool check,
                           const Body *bodies, Load *loads) {
  const Task task{material, limit2, check, bodies, loads};
  odd_.clear();
#if defined(__x86_64__)
  if (wide_packs()) return evaluate_wide(task, bonds_, odd_);
#endif
  return evaluate_all<Pack2, 2>(task, bonds_, odd_);
}

}  // namespace floe
