// SPDX-License-Identifier: GPL-2.0-or-later
#include "contact_batch.h"

#include "load_rows.h"
#include "pair_floe.h"

namespace floe {

namespace {

// The force of a contact is above what its ridge holds: the ridge closes.
template <bool Exact>
[[gnu::noinline]] void close(const ContactTask &t, int number, const ContactPose &pose,
                             double share, ContactSums &sums) {
  const Ends &ends = t.ends[number];
  const int i = ends.i, j = ends.j();
  ContactRow &row = t.rows[number];
  RidgeRow &ridge = t.ridges[number];
  const double span = (pose.radius_one + pose.radius_two) - row.rest;
  Ridge now{ridge.closing, ridge.thickness, ridge.length, t.covers[number]};
  const double before = span - pose.distance;
  const double closed = t.ridging->close_ridge(row.stiffness, span, before, now);
  row.rest += closed;
  ridge = {now.closing, now.thickness, now.length, t.ridging->ridging_limit(now)};
  t.covers[number] = now.cover;
  const double overlap = ((pose.radius_one + pose.radius_two) - pose.distance) - row.rest;
  // Over the step the force grew from that of the overlap before it.
  const double vn = (pose.v.x * pose.d.x + pose.v.y * pose.d.y) / pose.distance;
  const double mean = 0.5 * (overlap + larger(0.0, before + vn * t.step));
  sums.ridging += share * row.stiffness * mean * closed;
  const double area = now.length * closed;
  const int lo = t.ridging->lower(i, j), hi = i + j - lo;
  const double part = t.ridging->share_of(lo, hi) * area;
  add_load<Exact>(t.loads, lo, {0.0, 0.0, 0.0, part});
  add_load<Exact>(t.loads, hi, {0.0, 0.0, 0.0, area - part});
}

template <typename Terms, typename P, int Width>
FLOE_INLINE void evaluate_pack(const ContactTask &t, const int *numbers, int first, int count,
                               ContactSums &sums) {
  constexpr bool damped = Terms::damping != Damping::none;
  const double *row[Width], *one[Width], *two[Width];
  double *load_one[Width], *load_two[Width];
  int i[Width], j[Width];
  bool ghosts = false;
  for (int k = 0; k < Width; ++k) {
    const Ends ends = t.ends[numbers[k]];
    i[k] = ends.i;
    j[k] = ends.j();
    row[k] = &t.rows[numbers[k]].slip;
    one[k] = &t.bodies[i[k]].x;
    two[k] = &t.bodies[j[k]].x;
    load_one[k] = load_row<Terms::exact_sums>(t.loads, i[k]);
    load_two[k] = load_row<Terms::exact_sums>(t.loads, j[k]);
    ghosts |= j[k] >= t.nlocal;
  }
  P share = P{} + 1.0;
  if (ghosts) {
    for (int k = 0; k < Width; ++k) share[k] = j[k] < t.nlocal ? 1.0 : 0.5;
  }
  P h[4], d[4], a[4], b[4];
  columns(row, 0, h);
  differences(two, one, d);
  columns(one, 4, a);
  columns(two, 4, b);
  const P square = d[0] * d[0] + d[1] * d[1];
  const ContactPoseOf<P> pose{{d[0], d[1]}, root(square), a[3], b[3], {d[2], d[3]}, a[0], b[0]};
  P slip = h[0], rest = h[1], overlap, limit{};
  const P none{};
  if constexpr (Terms::ridging) {
    const double *ridge[Width];
    P r[4];
    for (int k = 0; k < Width; ++k) ridge[k] = &t.ridges[numbers[k]].closing;
    columns(ridge, 0, r);
    overlap = ((pose.radius_one + pose.radius_two) - pose.distance) - rest;
    limit = r[3];
    const auto closes = h[2] * overlap > limit;
    if (t.advance && any(closes)) {
      for (int k = 0; k < Width && k < count; ++k) {
        if (!closes[k]) continue;
        const ContactPose alone{{d[0][k], d[1][k]}, pose.distance[k], a[3][k], b[3][k],
                                {d[2][k], d[3][k]}, a[0][k],          b[0][k]};
        close<Terms::exact_sums>(t, numbers[k], alone, share[k], sums);
        for (int m = k; m < Width; ++m) {  // and the copies of it that fill the last pack
          if (numbers[m] != numbers[k]) continue;
          rest[m] = t.rows[numbers[k]].rest;
          limit[m] = t.ridges[numbers[k]].limit;
        }
      }
      overlap = ((pose.radius_one + pose.radius_two) - pose.distance) - rest;
    }
  } else {
    overlap = effective_overlap(pose, rest);
  }
  ContactLossOf<P> loss;
  ContactForceOf<P> touch = contact_force<Terms::friction, Terms::ridging, damped, P>(
      t.material, Terms::Law::at(ContactConstantsOf<P>{h[2], h[3]}, overlap), pose, overlap, t.step,
      slip, loss, limit);
  const auto idle = overlap <= none;
  const bool partial = any(idle) || count < Width;
  Load nowhere[Terms::exact_sums ? 2 : 1];
  if (partial) {
    for (Load &row : nowhere) row = {};
    if (Terms::friction) slip = idle ? none : slip;
    for (int k = 0; k < Width; ++k) {
      if (k < count && !idle[k]) continue;
      load_one[k] = load_two[k] = &nowhere[0].fx;
      share[k] = loss.damping[k] = loss.friction[k] = 0.0;
    }
  }
  if (t.advance) {
    for (int k = 0; k < Width; ++k) {
      if (Terms::friction) t.rows[numbers[k]].slip = slip[k];
      if (!Terms::ridging) t.rows[numbers[k]].rest = rest[k];
    }
  }
  if constexpr (Terms::damping == Damping::counted) sums.damping.add(first, share * loss.damping);
  if constexpr (Terms::friction) sums.friction.add(first, share * loss.friction);
  add_loads<Terms::exact_sums>(load_one, {touch.f.x, touch.f.y, touch.torque_one, none});
  add_loads<Terms::exact_sums>(load_two, {-touch.f.x, -touch.f.y, touch.torque_two, none});
  if constexpr (Terms::damping == Damping::exact) {
    const P inv = 1.0 / pose.distance, nx = d[0] * inv, ny = d[1] * inv;
    const P fx = -loss.normal * nx - loss.tangent * ny, fy = -loss.normal * ny + loss.tangent * nx;
    const P arm = pose.distance / (pose.radius_one + pose.radius_two) * loss.tangent;
    for (int k = 0; k < Width; ++k) {
      if (partial && !(k < count && !idle[k])) continue;
      load_one[k] = &t.damped[i[k]].fx;
      load_two[k] = &t.damped[j[k]].fx;
    }
    add_rows(load_one, {fx, fy, pose.radius_one * arm, none});
    add_rows(load_two, {-fx, -fy, pose.radius_two * arm, none});
  }
}

template <typename Terms, typename P, int Width>
FLOE_INLINE void evaluate_all(const ContactTask &t, int *numbers, int count, ContactSums &sums) {
  for (int k = count; k % 4; ++k) numbers[k] = numbers[k - 1];
  for (int first = 0; first < count; first += Width) {
    evaluate_pack<Terms, P, Width>(t, numbers + first, first % 4, count - first, sums);
  }
}

#if defined(__x86_64__)
template <typename Terms>
[[gnu::target("avx2")]] void evaluate_wide(const ContactTask &t, int *numbers, int count,
                                           ContactSums &sums) {
  evaluate_all<Terms, Pack4, 4>(t, numbers, count, sums);
}
#endif

}  // namespace

template <typename Terms>
void evaluate_contacts(const ContactTask &task, int *touching, int count, ContactSums &sums) {
  // Ridges close at a constant stiffness only: such a set of terms is never asked for.
  if constexpr (Terms::ridging && !Terms::Law::constant) return;
#if defined(__x86_64__)
  if (wide_packs()) return evaluate_wide<Terms>(task, touching, count, sums);
#endif
  evaluate_all<Terms, Pack2, 2>(task, touching, count, sums);
}

#define FLOE_CONTACTS(...)                                                                    \
  template void evaluate_contacts<ContactTerms<__VA_ARGS__>>(const ContactTask &, int *, int, \
                                                             ContactSums &);
#define FLOE_CONTACTS_DAMPED(Law, damping)         \
  FLOE_CONTACTS(false, false, damping, false, Law) \
  FLOE_CONTACTS(true, false, damping, false, Law)  \
  FLOE_CONTACTS(false, true, damping, false, Law)  \
  FLOE_CONTACTS(true, true, damping, false, Law)   \
  FLOE_CONTACTS(false, false, damping, true, Law)  \
  FLOE_CONTACTS(true, false, damping, true, Law)   \
  FLOE_CONTACTS(false, true, damping, true, Law)   \
  FLOE_CONTACTS(true, true, damping, true, Law)
#define FLOE_CONTACTS_OF(Law)                 \
  FLOE_CONTACTS_DAMPED(Law, Damping::none)    \
  FLOE_CONTACTS_DAMPED(Law, Damping::counted) \
  FLOE_CONTACTS_DAMPED(Law, Damping::exact)
FLOE_CONTACT_LAWS(FLOE_CONTACTS_OF)
#undef FLOE_CONTACTS_OF
#undef FLOE_CONTACTS_DAMPED
#undef FLOE_CONTACTS

}  // namespace floe
