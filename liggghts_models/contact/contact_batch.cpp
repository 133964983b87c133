// SPDX-License-Identifier: GPL-2.0-or-later
#include "contact_batch.h"

#include "history.h"

namespace floe {

namespace {

template <bool Friction, typename P, int Width>
FLOE_INLINE void evaluate_pack(const ContactTask &t, const Touching *pairs, int first, int count,
                               ContactSums &sums) {
  static_assert(slot::slip == 1 && slot::rest_overlap == 2 && slot::contact_stiffness == 3 &&
                    slot::contact_damping == 4,
                "the order in which columns are taken");
  const double *row[Width], *one[Width], *two[Width];
  double *load_one[Width], *load_two[Width];
  P share;
  for (int k = 0; k < Width; ++k) {
    row[k] = pairs[k].history;
    one[k] = &t.bodies[pairs[k].i].x;
    two[k] = &t.bodies[pairs[k].j].x;
    load_one[k] = &t.loads[pairs[k].i].fx;
    load_two[k] = &t.loads[pairs[k].j].fx;
    share[k] = pairs[k].j < t.nlocal ? 1.0 : 0.5;
  }
  P h[4], d[4], a[4], b[4];
  columns(row, slot::slip, h);
  differences(two, one, d);
  columns(one, 4, a);
  columns(two, 4, b);
  const P square = d[0] * d[0] + d[1] * d[1];
  const ContactPoseOf<P> pose{{d[0], d[1]}, root(square), a[3], b[3], {d[2], d[3]}, a[0], b[0]};
  P slip = h[0], rest = h[1];
  const P overlap = effective_overlap(pose, rest);
  ContactLossOf<P> loss;
  ContactForceOf<P> touch = contact_force<Friction, false, P>(t.material, {h[2], h[3]}, pose,
                                                              overlap, t.step, slip, loss);
  const P none{};
  const auto idle = overlap <= none;
  Load nowhere{};
  if (any(idle) || count < Width) {
    if (Friction) slip = idle ? none : slip;
    for (int k = 0; k < Width; ++k) {
      if (k < count && !idle[k]) continue;
      load_one[k] = load_two[k] = &nowhere.fx;
      share[k] = loss.damping[k] = loss.friction[k] = 0.0;
    }
  }
  if (t.advance) {
    for (int k = 0; k < Width; ++k) {
      if (Friction) pairs[k].history[slot::slip] = slip[k];
      pairs[k].history[slot::rest_overlap] = rest[k];
    }
  }
  sums.damping.add(first, share * loss.damping);
  if constexpr (Friction) sums.friction.add(first, share * loss.friction);
  add_rows(load_one, {touch.f.x, touch.f.y, touch.torque_one, none});
  add_rows(load_two, {-touch.f.x, -touch.f.y, touch.torque_two, none});
}

template <bool Friction, typename P, int Width>
FLOE_INLINE void evaluate_all(const ContactTask &t, Touching *pairs, int count, ContactSums &sums) {
  for (int k = count; k % 4; ++k) pairs[k] = pairs[k - 1];
  for (int first = 0; first < count; first += Width) {
    evaluate_pack<Friction, P, Width>(t, pairs + first, first % 4, count - first, sums);
  }
}

#if defined(__x86_64__)
template <bool Friction>
[[gnu::target("avx2")]] void evaluate_wide(const ContactTask &t, Touching *pairs, int count,
                                           ContactSums &sums) {
  evaluate_all<Friction, Pack4, 4>(t, pairs, count, sums);
}
#endif

}  // namespace

template <bool Friction>
void evaluate_contacts(const ContactTask &task, Touching *pairs, int count, ContactSums &sums) {
#if defined(__x86_64__)
  if (wide_packs()) return evaluate_wide<Friction>(task, pairs, count, sums);
#endif
  evaluate_all<Friction, Pack2, 2>(task, pairs, count, sums);
}

template void evaluate_contacts<true>(const ContactTask &, Touching *, int, ContactSums &);
template void evaluate_contacts<false>(const ContactTask &, Touching *, int, ContactSums &);

}  // namespace floe
