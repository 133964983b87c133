// SPDX-License-Identifier: GPL-2.0-or-later
#include "bond_batch.h"

#include "fetch_ahead.h"
#include "lane_sums.h"
#include "load_rows.h"

namespace floe {

namespace {

template <typename P>
struct BatchState {
  BondShapeOf<P> shape;
  BondConstantsOf<P> constants;
  BondPoseOf<P> pose;
  P radii;
};

// Records and elements of one bond per lane, as packs.
template <typename P, int Width>
FLOE_INLINE BatchState<P> gather(const BondBlock &block, const BondRest &rest, int first,
                                 const Body *bodies) {
  const auto column = [&](int k) { return load_pack<P>(block.column[k] + first); };
  using B = BondBlock;
  BatchState<P> out;
  out.shape = {{column(B::lo_ax), column(B::lo_ay)},
               {column(B::lo_bx), column(B::lo_by)},
               {column(B::hi_ax), column(B::hi_ay)},
               {column(B::hi_bx), column(B::hi_by)},
               P{},
               P{},
               load_pack<P>(rest.crack_a + first),
               load_pack<P>(rest.crack_b + first)};
  out.constants = {column(B::length), column(B::ratio), column(B::damping), column(B::squeeze)};
  const double *lo[Width], *hi[Width];
  for (int k = 0; k < Width; ++k) {
    lo[k] = &bodies[block.lo[first + k]].x;
    hi[k] = &bodies[block.hi[first + k]].x;
  }
  P a[4], c[4], d[4];
  differences(hi, lo, a);
  columns(lo, 4, c);
  columns(hi, 4, d);
  out.pose = {{a[0], a[1]}, {c[1], c[2]}, {d[1], d[2]}, {a[2], a[3]}, c[0], d[0]};
  out.radii = c[3] + d[3];
  return out;
}

// The first `count` lanes are bonds; without Whole there may be fewer than lanes.
template <typename Law, Damping Damp, bool Exact, bool Whole, typename P, int Width>
FLOE_INLINE void evaluate_pack(const BondTask &t, const BondBlock &block, const BondRest &rest,
                               int number, int first, int count, P &sum, std::vector<int> &odd) {
  constexpr bool damped = Damp != Damping::none;
  const BatchState<P> s = gather<P, Width>(block, rest, first, t.bodies);
  const BondLineOf<P> line = bond_line(s.shape, s.pose);
  P power;
  const PairForceOf<P> force =
      Law::template force<damped>(t.material, s.constants, s.shape, line, s.pose, power);
  const P none{};
  auto holds = none == none;
  if (t.check) {
    const P square = s.pose.d.x * s.pose.d.x + s.pose.d.y * s.pose.d.y;
    holds = Law::holds(t.material, s.constants, line, s.shape) &
            (square <= t.limit2 * s.radii * s.radii);
  }
  int lo[Width], hi[Width];
  double *to_lo[Width], *to_hi[Width];
  Load nowhere[Exact ? 2 : 1];
  for (int k = 0; k < Width; ++k) {
    lo[k] = block.lo[first + k];
    hi[k] = block.hi[first + k];
    to_lo[k] = load_row<Exact>(t.loads, lo[k]);
    to_hi[k] = load_row<Exact>(t.loads, hi[k]);
  }
  const bool whole = Whole && all(holds);
  if (!whole) {
    for (Load &row : nowhere) row = {};
    for (int k = 0; k < Width; ++k) {
      if (k < count && holds[k]) continue;
      to_lo[k] = to_hi[k] = &nowhere[0].fx;
      power[k] = 0.0;
      if (k < count) odd.push_back(number + k);
    }
  }
  if constexpr (Damp == Damping::counted) {
    sum += load_pack<P>(rest.share + first) * power;
  }
  add_loads<Exact>(to_lo, {force.f.x, force.f.y, force.torque_lo, none});
  add_loads<Exact>(to_hi, {-force.f.x, -force.f.y, force.torque_hi, none});
  if constexpr (Damp == Damping::exact) {
    BondLineOf<P> still = line;
    still.dn = still.dn_slope = still.dt = none;
    const PairForceOf<P> part =
        Law::template force<true>(t.material, s.constants, s.shape, still, s.pose, power);
    for (int k = 0; k < Width; ++k) {
      if (!whole && !(k < count && holds[k])) continue;
      to_lo[k] = &t.damped[lo[k]].fx;
      to_hi[k] = &t.damped[hi[k]].fx;
    }
    add_rows(to_lo, {part.f.x, part.f.y, part.torque_lo, none});
    add_rows(to_hi, {-part.f.x, -part.f.y, part.torque_hi, none});
  }
}

// Blocks that a block's elements are asked for ahead of it; its own lines twice as many.
constexpr int ahead = 8;

template <bool Exact>
FLOE_INLINE void fetch_ahead(const BondTask &t, const BondBlock *block) {
  fetch_all(block + 2 * ahead, 1);
  const BondBlock &next = block[ahead];
  for (int k = 0; k < 4; ++k) {
    fetch(t.bodies + next.lo[k]);
    fetch(t.bodies + next.hi[k]);
    fetch(load_row<Exact>(t.loads, next.lo[k]));
    fetch(load_row<Exact>(t.loads, next.hi[k]));
  }
}

template <typename Law, Damping Damp, bool Exact, bool Far, typename P, int Width>
FLOE_INLINE double evaluate_all(const BondTask &t, const BondRecords &bonds,
                                std::vector<int> &odd) {
  constexpr int parts = 4 / Width;
  P part[parts] = {};
  const int count = bonds.count, whole = count / 4 * 4;
  const BondBlock *block = bonds.blocks.data();
  for (int first = 0; first < whole; first += 4, ++block) {
    if constexpr (Far) {
      if (first < whole - 8 * ahead) fetch_ahead<Exact>(t, block);
    }
    const BondRest &rest = bonds.rest(first);
    for (int k = 0; k < parts; ++k) {
      evaluate_pack<Law, Damp, Exact, true, P, Width>(t, *block, rest, first + k * Width, k * Width,
                                                      Width, part[k], odd);
    }
  }
  for (int k = 0; k < parts && whole + k * Width < count; ++k) {
    evaluate_pack<Law, Damp, Exact, false, P, Width>(t, *block, bonds.rest(whole),
                                                     whole + k * Width, k * Width,
                                                     count - whole - k * Width, part[k], odd);
  }
  LaneSums sums;
  for (int k = 0; k < parts; ++k) sums.add(k * Width, part[k]);
  return sums.total();
}

#if defined(__x86_64__)
template <typename Law, Damping Damp, bool Exact, bool Far>
[[gnu::target("avx2")]] double evaluate_wide(const BondTask &t, const BondRecords &bonds,
                                             std::vector<int> &odd) {
  return evaluate_all<Law, Damp, Exact, Far, Pack4, 4>(t, bonds, odd);
}
#endif

template <typename Law, Damping Damp, bool Exact, bool Far>
double evaluate_narrow(const BondTask &t, const BondRecords &bonds, std::vector<int> &odd) {
  return evaluate_all<Law, Damp, Exact, Far, Pack2, 2>(t, bonds, odd);
}

}  // namespace

template <typename Law, Damping Damp, bool Exact>
double evaluate_bonds(const BondTask &task, const BondRecords &bonds, std::vector<int> &odd) {
  const bool far = bonds.blocks.size() * sizeof(BondBlock) > cached_bytes;
#if defined(__x86_64__)
  if (wide_packs()) {
    return far ? evaluate_wide<Law, Damp, Exact, true>(task, bonds, odd)
               : evaluate_wide<Law, Damp, Exact, false>(task, bonds, odd);
  }
#endif
  return far ? evaluate_narrow<Law, Damp, Exact, true>(task, bonds, odd)
             : evaluate_narrow<Law, Damp, Exact, false>(task, bonds, odd);
}

#define FLOE_BONDS(Law, damp, exact)                                                      \
  template double evaluate_bonds<Law, damp, exact>(const BondTask &, const BondRecords &, \
                                                   std::vector<int> &);
#define FLOE_BONDS_OF(Law)                 \
  FLOE_BONDS(Law, Damping::none, false)    \
  FLOE_BONDS(Law, Damping::none, true)     \
  FLOE_BONDS(Law, Damping::counted, false) \
  FLOE_BONDS(Law, Damping::counted, true)  \
  FLOE_BONDS(Law, Damping::exact, false)   \
  FLOE_BONDS(Law, Damping::exact, true)
FLOE_BOND_LAWS(FLOE_BONDS_OF)
#undef FLOE_BONDS_OF
#undef FLOE_BONDS

}  // namespace floe
