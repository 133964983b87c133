// SPDX-License-Identifier: GPL-2.0-or-later
//
// Arrays that every step reads and writes from end to end. Long ones ask for large pages of memory: the
// processor then looks up a place once in 2 MiB, not once in 4 KiB, and fetches ahead further.
#ifndef FLOE_CONTACT_LARGE_PAGES_H
#define FLOE_CONTACT_LARGE_PAGES_H

#include <cstddef>
#include <new>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace floe {

template <typename T>
struct LargePages {
  using value_type = T;
  static constexpr std::size_t page = std::size_t{1} << 21;

  LargePages() = default;
  template <typename U>
  LargePages(const LargePages<U> &) {}

  T *allocate(std::size_t count) {
    void *at = ::operator new(bytes(count), alignment(count));
#if defined(MADV_HUGEPAGE)
    // Advice: where it is not taken, the pages are small.
    if (large(count)) madvise(at, bytes(count), MADV_HUGEPAGE);
#endif
    return static_cast<T *>(at);
  }
  void deallocate(T *at, std::size_t count) {
    ::operator delete(at, bytes(count), alignment(count));
  }
  friend bool operator==(const LargePages &, const LargePages &) { return true; }
  friend bool operator!=(const LargePages &, const LargePages &) { return false; }

 private:
  static bool large(std::size_t count) { return count * sizeof(T) >= page; }
  static std::size_t bytes(std::size_t count) {
    const std::size_t size = count * sizeof(T);
    return large(count) ? (size + page - 1) / page * page : size;
  }
  static std::align_val_t alignment(std::size_t count) {
    return std::align_val_t{large(count)                             ? page
                            : alignof(std::max_align_t) < alignof(T) ? alignof(T)
                                                                     : alignof(std::max_align_t)};
  }
};

template <typename T>
using LongArray = std::vector<T, LargePages<T>>;

}  // namespace floe

#endif
