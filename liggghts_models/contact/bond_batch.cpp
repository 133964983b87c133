// SPDX-License-Identifier: GPL-2.0-or-later
#include "bond_batch.h"

#include <cstddef>

#include "history.h"

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
FLOE_INLINE BatchState<P> gather(const BatchBond *bonds, const Body *bodies) {
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
  columns(lo, 0, a);
  columns(hi, 0, b);
  columns(lo, 4, c);
  columns(hi, 4, d);
  out.pose = {{b[0] - a[0], b[1] - a[1]}, {c[1], c[2]}, {d[1], d[2]},
              {b[2] - a[2], b[3] - a[3]}, c[0],         d[0]};
  out.radii = c[3] + d[3];
  return out;
}

}  // namespace

template <typename P, int Width>
FLOE_INLINE int BondBatch::evaluate_all() {
  const int count = count_;
  int left = 0;
  for (int k = count; k < count + Width - 1; ++k) bonds_[k] = bonds_[0];
  for (int first = 0; first < count; first += Width) {
    BatchBond *const bonds = bonds_ + first;
    const BatchState<P> s = gather<P, Width>(bonds, bodies_);
    const BondLineOf<P> line = bond_line(s.shape, s.pose);
    P power;
    const PairForceOf<P> force = bond_force(material_, s.constants, s.shape, line, s.pose, power);
    const P none{};
    auto holds = none == none;
    if (check_) {
      const auto limits = bond_limits(material_, s.constants, line);
      const auto range = bond_range(line, s.shape);
      const P square = s.pose.d.x * s.pose.d.x + s.pose.d.y * s.pose.d.y;
      holds = (range.least >= limits.least) & (range.most <= limits.most) &
              (square <= limit2_ * s.radii * s.radii);
    }
    double *load_lo[Width], *load_hi[Width];
    Load nowhere{};
    bool present[Width];
    for (int k = 0; k < Width; ++k) {
      const bool real = first + k < count;
      present[k] = real && holds[k];
      load_lo[k] = present[k] ? &loads_[bonds[k].lo].fx : &nowhere.fx;
      load_hi[k] = present[k] ? &loads_[bonds[k].hi].fx : &nowhere.fx;
    }
    add_rows(load_lo, {force.f.x, force.f.y, force.torque_lo, none});
    add_rows(load_hi, {-force.f.x, -force.f.y, force.torque_hi, none});
    for (int k = 0; k < Width; ++k) {
      if (present[k])
        watt += bonds[k].share * power[k];
      else if (first + k < count)
        bonds_[left++] = bonds[k];
    }
  }
  return left;
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] int BondBatch::evaluate_wide() { return evaluate_all<Pack4, 4>(); }

int BondBatch::evaluate() {
  static const bool wide = __builtin_cpu_supports("avx2");
  return wide ? evaluate_wide() : evaluate_all<Pack2, 2>();
}
#else
int BondBatch::evaluate() { return evaluate_all<Pack2, 2>(); }
#endif

}  // namespace floe
