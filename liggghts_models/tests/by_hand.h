// SPDX-License-Identifier: GPL-2.0-or-later
//
// The loops of the pair style once more, written by hand for one set of terms each: what is off was
// never there. Instructions are counted against these (tests/unit/dynamics/test_pair_loop_cost.py).
#ifndef FLOE_TESTS_BY_HAND_H
#define FLOE_TESTS_BY_HAND_H

#include <cmath>

#include "body.h"
#include "contact_batch.h"
#include "pack.h"
#include "records.h"

namespace by_hand {

using namespace floe;

// What all laws read of a pack of pairs, and where their loads go.
template <typename P, int Width>
struct Pairs {
  P h[4], d[4], a[4], b[4];
  P share = P{} + 1.0;
  double *load_one[Width], *load_two[Width];

  FLOE_INLINE Pairs(const ContactTask &t, const int *pairs) {
    const double *row[Width], *one[Width], *two[Width];
    int i[Width], j[Width];
    bool ghosts = false;
    for (int k = 0; k < Width; ++k) {
      const Ends ends = t.ends[pairs[k]];
      i[k] = ends.i;
      j[k] = ends.j();
      row[k] = &t.rows[pairs[k]].slip;
      one[k] = &t.bodies[i[k]].x;
      two[k] = &t.bodies[j[k]].x;
      load_one[k] = &t.loads[i[k]].fx;
      load_two[k] = &t.loads[j[k]].fx;
      ghosts |= j[k] >= t.nlocal;
    }
    if (ghosts) {
      for (int k = 0; k < Width; ++k) share[k] = j[k] < t.nlocal ? 1.0 : 0.5;
    }
    columns(row, 0, h);
    differences(two, one, d);
    columns(one, 4, a);
    columns(two, 4, b);
  }
};

// Elastic, damped, never attractive, with the overlap at rest that broken bonds leave: no more.
struct Push {
  template <typename P, int Width>
  FLOE_INLINE void evaluate(const ContactTask &t, const int *pairs, int first, int count,
                            LaneSums *sums) const {
    Pairs<P, Width> g(t, pairs);
    const auto &h = g.h, &d = g.d, &a = g.a, &b = g.b;
    const P zero{}, distance = root(d[0] * d[0] + d[1] * d[1]);
    const P gap = (a[3] + b[3]) - distance, rest = larger(zero, smaller(h[1], gap));
    const P overlap = gap - rest;
    const P inv = 1.0 / distance, nx = d[0] * inv, ny = d[1] * inv;
    const P elastic = h[2] * overlap, vn = d[2] * nx + d[3] * ny;
    const P fn = larger(elastic - h[3] * vn, zero);
    P power = -(fn - elastic) * vn;
    const auto idle = overlap <= zero;
    Load nowhere;
    if (any(idle) || count < Width) {
      nowhere = {};
      for (int k = 0; k < Width; ++k) {
        if (k < count && !idle[k]) continue;
        g.load_one[k] = g.load_two[k] = &nowhere.fx;
        g.share[k] = power[k] = 0.0;
      }
    }
    if (t.advance) {
      for (int k = 0; k < Width; ++k) t.rows[pairs[k]].rest = rest[k];
    }
    sums[0].add(first, g.share * power);
    add_rows(g.load_one, {-fn * nx, -fn * ny, zero, zero});
    add_rows(g.load_two, {fn * nx, fn * ny, zero, zero});
  }
};

// The same without damping, with friction.
struct Rub {
  template <typename P, int Width>
  FLOE_INLINE void evaluate(const ContactTask &t, const int *pairs, int first, int count,
                            LaneSums *sums) const {
    Pairs<P, Width> g(t, pairs);
    const auto &h = g.h, &d = g.d, &a = g.a, &b = g.b;
    const P zero{}, distance = root(d[0] * d[0] + d[1] * d[1]), radii = a[3] + b[3];
    const P overlap = radii - distance, rest = larger(zero, smaller(h[1], overlap));
    const P inv = 1.0 / distance, nx = d[0] * inv, ny = d[1] * inv;
    const P fn = larger(h[2] * (overlap - rest), zero);
    const P lever = distance / radii, arm_one = a[3] * lever, arm_two = b[3] * lever;
    const P turning = a[0] * arm_one + b[0] * arm_two;
    const P vt = (d[3] * nx - d[2] * ny) - turning;
    const P kt = t.material.shear_ratio * h[2], limit = t.material.friction * fn;
    const P trial = h[0] + vt * t.step;
    P slip = trial, lost = zero;
    if (any(magnitude(kt * trial) > limit)) {
      const auto slides = magnitude(kt * trial) > limit;
      const P cap = limit / kt;
      slip = slides ? (trial < zero ? -cap : cap) : trial;
      lost = slides ? (trial - slip) * (kt * 0.5 * (h[0] + slip)) : zero;
    }
    const P ft = kt * slip;
    const auto idle = overlap - rest <= zero;
    Load nowhere;
    if (any(idle) || count < Width) {
      nowhere = {};
      slip = idle ? zero : slip;
      for (int k = 0; k < Width; ++k) {
        if (k < count && !idle[k]) continue;
        g.load_one[k] = g.load_two[k] = &nowhere.fx;
        g.share[k] = lost[k] = 0.0;
      }
    }
    if (t.advance) {
      for (int k = 0; k < Width; ++k) {
        t.rows[pairs[k]].slip = slip[k];
        t.rows[pairs[k]].rest = rest[k];
      }
    }
    sums[0].add(first, g.share * lost);
    add_rows(g.load_one, {-fn * nx - ft * ny, -fn * ny + ft * nx, arm_one * ft, zero});
    add_rows(g.load_two, {fn * nx + ft * ny, fn * ny - ft * nx, arm_two * ft, zero});
  }
};

template <typename Law, typename P, int Width>
FLOE_INLINE void evaluate_all(const ContactTask &t, int *pairs, int count, LaneSums *sums) {
  for (int k = count; k % 4; ++k) pairs[k] = pairs[k - 1];
  for (int first = 0; first < count; first += Width) {
    Law{}.template evaluate<P, Width>(t, pairs + first, first % 4, count - first, sums);
  }
}

#if defined(__x86_64__)
template <typename Law>
[[gnu::target("avx2"), gnu::noinline]] void evaluate_wide(const ContactTask &t, int *pairs,
                                                          int count, LaneSums *sums) {
  evaluate_all<Law, Pack4, 4>(t, pairs, count, sums);
}
#endif

template <typename Law>
[[gnu::noinline]] void evaluate_some(const ContactTask &t, int *pairs, int count, LaneSums *sums) {
#if defined(__x86_64__)
  if (wide_packs()) return evaluate_wide<Law>(t, pairs, count, sums);
#endif
  evaluate_all<Law, Pack2, 2>(t, pairs, count, sums);
}

template <typename Law, typename Start, typename Forget>
FLOE_INLINE void loop_contacts(const ContactTask &t, int count, LaneSums *sums, Start start,
                               Forget forget) {
  constexpr int room = 256;
  int touching[room + 3], found = 0;
  const Body *bodies = t.bodies;
  const Ends *ends = t.ends;
  for (int k = 0; k < count; ++k) {
    const Body &one = bodies[ends[k].i], &two = bodies[ends[k].j()];
    const double dx = two.x - one.x, dy = two.y - one.y, sum = one.radius + two.radius;
    if (dx * dx + dy * dy >= sum * sum) {
      if (ends[k].touching()) forget(k);
      continue;
    }
    if (!ends[k].touching()) start(k);
    touching[found++] = k;
    if (found < room) continue;
    evaluate_some<Law>(t, touching, found, sums);
    found = 0;
  }
  if (found) evaluate_some<Law>(t, touching, found, sums);
}

// A glue line: elastic, whole or cracked, without damping.
template <typename P, int Width>
FLOE_INLINE void stretch(const BondMaterial &m, double limit2, const BondBlock &b,
                         const BondRest &rest, int number, int first, int count, const Body *bodies,
                         Load *loads, std::vector<int> &odd) {
  const auto column = [&](int k) { return load_pack<P>(b.column[k] + first); };
  using B = BondBlock;
  const double *lo[Width], *hi[Width];
  double *to_lo[Width], *to_hi[Width];
  for (int k = 0; k < Width; ++k) {
    lo[k] = &bodies[b.lo[first + k]].x;
    hi[k] = &bodies[b.hi[first + k]].x;
    to_lo[k] = &loads[b.lo[first + k]].fx;
    to_hi[k] = &loads[b.hi[first + k]].fx;
  }
  P d[4], one[4], two[4];
  differences(hi, lo, d);
  columns(lo, 4, one);
  columns(hi, 4, two);
  const P lc = one[1], ls = one[2], hc = two[1], hs = two[2];
  const P lax = lc * column(B::lo_ax) - ls * column(B::lo_ay);
  const P lay = ls * column(B::lo_ax) + lc * column(B::lo_ay);
  const P lbx = lc * column(B::lo_bx) - ls * column(B::lo_by);
  const P lby = ls * column(B::lo_bx) + lc * column(B::lo_by);
  const P hax = hc * column(B::hi_ax) - hs * column(B::hi_ay);
  const P hay = hs * column(B::hi_ax) + hc * column(B::hi_ay);
  const P hbx = hc * column(B::hi_bx) - hs * column(B::hi_by);
  const P hby = hs * column(B::hi_bx) + hc * column(B::hi_by);
  const P lx = lbx - lax, ly = lby - lay, hx = hbx - hax, hy = hby - hay;
  const P sx = lx + hx, sy = ly + hy, norm = root(sx * sx + sy * sy), inv = 1.0 / norm;
  const P tx = sx * inv, ty = sy * inv, nx = ty, ny = -tx, length = 0.5 * norm;
  const P mlx = 0.5 * (lax + lbx), mly = 0.5 * (lay + lby);
  const P mhx = 0.5 * (hax + hbx), mhy = 0.5 * (hay + hby);
  const P mx = d[0] + (mhx - mlx), my = d[1] + (mhy - mly);
  const P dn = mx * nx + my * ny, dt = mx * tx + my * ty;
  const P bend = (hx - lx) * nx + (hy - ly) * ny;
  const P alx = mlx + 0.5 * mx, aly = mly + 0.5 * my;
  const P ahx = mhx - 0.5 * mx, ahy = mhy - 0.5 * my;
  const P zero{};
  const P xi_lo = load_pack<P>(rest.crack_a + first);
  const P xi_hi = 1.0 - load_pack<P>(rest.crack_b + first);
  const P kn = m.young * column(B::ratio), kt = m.shear * column(B::ratio);
  const P w = xi_hi - xi_lo, xm = 0.5 * (xi_lo + xi_hi) - 0.5, lw = column(B::length) * w;
  const P qn = kn * (dn + xm * bend), fn = lw * qn, ft = lw * (kt * dt);
  const P moment = -length * lw * (xm * qn + kn * bend * w * w / 12.0);
  const P fx = fn * nx + ft * tx, fy = fn * ny + ft * ty;
  const P torque_lo = (alx * fy - aly * fx) + moment, torque_hi = -(ahx * fy - ahy * fx) - moment;
  const P squeeze = column(B::squeeze), sum = one[3] + two[3];
  const P end_a = dn + (xi_lo - 0.5) * bend, end_b = dn + (xi_hi - 0.5) * bend;
  const auto holds =
      (smaller(end_a, end_b) >= -squeeze) &
      (larger(end_a, end_b) <= m.tensile_share * squeeze - m.shear_slope * magnitude(dt)) &
      (d[0] * d[0] + d[1] * d[1] <= limit2 * sum * sum);
  Load nowhere;
  if (count < Width || !all(holds)) {
    nowhere = {};
    for (int k = 0; k < Width; ++k) {
      if (k < count && holds[k]) continue;
      to_lo[k] = to_hi[k] = &nowhere.fx;
      if (k < count) odd.push_back(number + k);
    }
  }
  add_rows(to_lo, {fx, fy, torque_lo, zero});
  add_rows(to_hi, {-fx, -fy, torque_hi, zero});
}

template <typename P, int Width>
FLOE_INLINE void stretch_all(const BondMaterial &m, double limit2, const BondRecords &bonds,
                             const Body *bodies, Load *loads, std::vector<int> &odd) {
  const BondBlock *block = bonds.blocks.data();
  for (int first = 0; first < bonds.count; first += 4, ++block) {
    const BondRest &rest = bonds.rest(first);
    for (int k = 0; k < 4 && first + k < bonds.count; k += Width) {
      stretch<P, Width>(m, limit2, *block, rest, first + k, k, bonds.count - first - k, bodies,
                        loads, odd);
    }
  }
}

#if defined(__x86_64__)
[[gnu::target("avx2"),
  gnu::noinline]] inline void stretch_wide(const BondMaterial &m, double limit2,
                                           const BondRecords &bonds, const Body *bodies,
                                           Load *loads, std::vector<int> &odd) {
  stretch_all<Pack4, 4>(m, limit2, bonds, bodies, loads, odd);
}
#endif

}  // namespace by_hand

#endif
