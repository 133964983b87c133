// SPDX-License-Identifier: GPL-2.0-or-later
//
// Several numbers at once. The laws are templates over their number type: with a pack they work on
// two or four pairs in one pass, with the same bits as one by one, because each lane sees the same
// operations. Without a header of the processor's: GCC and Clang know such vectors on every machine.
#ifndef FLOE_LAWS_PACK_H
#define FLOE_LAWS_PACK_H

#include <cmath>
#include <cstdint>
#include <cstring>

// Laws are inlined into loops that are compiled for more than one set of instructions.
#define FLOE_INLINE [[gnu::always_inline]] inline

namespace floe {

using Pack2 = double __attribute__((vector_size(16)));
using Pack4 = double __attribute__((vector_size(32)));
using Mask2 = decltype(Pack2{} < Pack2{});
using Mask4 = decltype(Pack4{} < Pack4{});

// As std::min and std::max: the first argument where the two do not compare.
template <typename T>
FLOE_INLINE T smaller(T a, T b) {
  return b < a ? b : a;
}
template <typename T>
FLOE_INLINE T larger(T a, T b) {
  return a < b ? b : a;
}

FLOE_INLINE double magnitude(double a) { return std::fabs(a); }
FLOE_INLINE Pack2 magnitude(Pack2 a) {
  return reinterpret_cast<Pack2>(reinterpret_cast<Mask2>(a) & INT64_MAX);
}
FLOE_INLINE Pack4 magnitude(Pack4 a) {
  return reinterpret_cast<Pack4>(reinterpret_cast<Mask4>(a) & INT64_MAX);
}

FLOE_INLINE double root(double a) { return std::sqrt(a); }
FLOE_INLINE bool any(bool m) { return m; }
#if defined(__x86_64__)
// One instruction each. Written down, because a law is inlined into code for wider packs than the
// compiler may use where the law stands.
FLOE_INLINE Pack2 root(Pack2 a) {
  asm("sqrtpd %1, %0" : "=x"(a) : "x"(a));
  return a;
}
FLOE_INLINE Pack4 root(Pack4 a) {
  asm("vsqrtpd %1, %0" : "=x"(a) : "x"(a));
  return a;
}
FLOE_INLINE int lanes(Mask2 m) {
  int out;
  asm("movmskpd %1, %0" : "=r"(out) : "x"(m));
  return out;
}
FLOE_INLINE int lanes(Mask4 m) {
  int out;
  asm("vmovmskpd %1, %0" : "=r"(out) : "x"(m));
  return out;
}
FLOE_INLINE bool any(Mask2 m) { return lanes(m) != 0; }
FLOE_INLINE bool any(Mask4 m) { return lanes(m) != 0; }
FLOE_INLINE bool all(Mask2 m) { return lanes(m) == 3; }
FLOE_INLINE bool all(Mask4 m) { return lanes(m) == 15; }
#else
FLOE_INLINE Pack2 root(Pack2 a) { return Pack2{std::sqrt(a[0]), std::sqrt(a[1])}; }
FLOE_INLINE bool any(Mask2 m) { return (m[0] | m[1]) != 0; }
FLOE_INLINE bool all(Mask2 m) { return (m[0] & m[1]) != 0; }
FLOE_INLINE Pack4 root(Pack4 a) {
  return Pack4{std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])};
}
FLOE_INLINE bool any(Mask4 m) { return ((m[0] | m[1]) | (m[2] | m[3])) != 0; }
FLOE_INLINE bool all(Mask4 m) { return ((m[0] & m[1]) & (m[2] & m[3])) != 0; }
#endif

template <typename P>
FLOE_INLINE P load_pack(const double *from) {
  P out;
  std::memcpy(&out, from, sizeof out);
  return out;
}
template <typename P>
FLOE_INLINE void add_pack(double *to, P a) {
  a += load_pack<P>(to);
  std::memcpy(to, &a, sizeof a);
}

// Four numbers from each lane's row, as four packs; and back.
FLOE_INLINE void columns(const double *const (&row)[2], int first, Pack2 (&out)[4]) {
  for (int k = 0; k < 4; k += 2) {
    const Pack2 a = load_pack<Pack2>(row[0] + first + k), b = load_pack<Pack2>(row[1] + first + k);
    out[k] = __builtin_shuffle(a, b, Mask2{0, 2});
    out[k + 1] = __builtin_shuffle(a, b, Mask2{1, 3});
  }
}
FLOE_INLINE void transpose(Pack4 (&m)[4]) {
  const Pack4 a = __builtin_shuffle(m[0], m[1], Mask4{0, 4, 2, 6});
  const Pack4 b = __builtin_shuffle(m[0], m[1], Mask4{1, 5, 3, 7});
  const Pack4 c = __builtin_shuffle(m[2], m[3], Mask4{0, 4, 2, 6});
  const Pack4 d = __builtin_shuffle(m[2], m[3], Mask4{1, 5, 3, 7});
  m[0] = __builtin_shuffle(a, c, Mask4{0, 1, 4, 5});
  m[1] = __builtin_shuffle(b, d, Mask4{0, 1, 4, 5});
  m[2] = __builtin_shuffle(a, c, Mask4{2, 3, 6, 7});
  m[3] = __builtin_shuffle(b, d, Mask4{2, 3, 6, 7});
}
FLOE_INLINE void columns(const double *const (&row)[4], int first, Pack4 (&out)[4]) {
  for (int k = 0; k < 4; ++k) out[k] = load_pack<Pack4>(row[k] + first);
  transpose(out);
}
// The same of the differences of two rows.
FLOE_INLINE void differences(const double *const (&a)[2], const double *const (&b)[2],
                             Pack2 (&out)[4]) {
  for (int k = 0; k < 4; k += 2) {
    const Pack2 first = load_pack<Pack2>(a[0] + k) - load_pack<Pack2>(b[0] + k);
    const Pack2 second = load_pack<Pack2>(a[1] + k) - load_pack<Pack2>(b[1] + k);
    out[k] = __builtin_shuffle(first, second, Mask2{0, 2});
    out[k + 1] = __builtin_shuffle(first, second, Mask2{1, 3});
  }
}
FLOE_INLINE void differences(const double *const (&a)[4], const double *const (&b)[4],
                             Pack4 (&out)[4]) {
  for (int k = 0; k < 4; ++k) out[k] = load_pack<Pack4>(a[k]) - load_pack<Pack4>(b[k]);
  transpose(out);
}
FLOE_INLINE void add_rows(double *const (&row)[2], const Pack2 (&in)[4]) {
  for (int k = 0; k < 4; k += 2) {
    add_pack(row[0] + k, __builtin_shuffle(in[k], in[k + 1], Mask2{0, 2}));
    add_pack(row[1] + k, __builtin_shuffle(in[k], in[k + 1], Mask2{1, 3}));
  }
}
FLOE_INLINE void add_rows(double *const (&row)[4], const Pack4 (&in)[4]) {
  Pack4 m[4] = {in[0], in[1], in[2], in[3]};
  transpose(m);
  for (int k = 0; k < 4; ++k) add_pack(row[k], m[k]);
}

// Whether this processor works on packs of four.
inline bool wide_packs() {
#if defined(__x86_64__)
  static const bool wide = __builtin_cpu_supports("avx2");
  return wide;
#else
  return false;
#endif
}

}  // namespace floe

#endif
