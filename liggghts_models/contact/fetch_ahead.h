// SPDX-License-Identifier: GPL-2.0-or-later
//
// Asking memory for what a loop reads soon. The processor does so on its own within a page of memory
// and along few arrays at once; the loop over bonds goes along many, and to neighbours in another row.
// It changes no bit, and is done only where the bonds do not stay in the caches.
#ifndef FLOE_CONTACT_FETCH_AHEAD_H
#define FLOE_CONTACT_FETCH_AHEAD_H

#include <cstddef>

#include "pack.h"

namespace floe {

constexpr std::size_t cached_bytes = std::size_t{1} << 20;

FLOE_INLINE void fetch(const void *at) { __builtin_prefetch(at); }

// All lines of some records in a row.
template <typename T>
FLOE_INLINE void fetch_all(const T *at, int count) {
  const char *from = reinterpret_cast<const char *>(at);
  for (std::size_t k = 0; k < count * sizeof(T); k += 64) fetch(from + k);
}

}  // namespace floe

#endif
