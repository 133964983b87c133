// SPDX-License-Identifier: GPL-2.0-or-later
#include "records.h"

#include <limits>

namespace floe {

void BondRecords::clear() {
  count = 0;
  blocks.clear();
  rests.clear();
  plain.clear();
  places.clear();
}

void BondRecords::add(int lo, int hi, double share, const BondShape &b, const BondConstants &c,
                      Place place) {
  const int k = count++;
  // The lanes behind the last bond hold copies of the block's first, which are not counted.
  const int last = k % 4 == 0 ? k + 4 : k + 1;
  if (k % 4 == 0) {
    blocks.emplace_back();
    rests.emplace_back();
    plain.push_back(true);
  }
  if (b.crack_a != 0.0 || b.crack_b != 0.0 || share != 1.0) plain.back() = false;
  for (int lane = k; lane < last; ++lane) {
    using B = BondBlock;
    const auto put = [&](B::Column column, double value) {
      blocks.back().column[column][lane & 3] = value;
    };
    put(B::lo_ax, b.lo_a.x), put(B::lo_ay, b.lo_a.y);
    put(B::lo_bx, b.lo_b.x), put(B::lo_by, b.lo_b.y);
    put(B::hi_ax, b.hi_a.x), put(B::hi_ay, b.hi_a.y);
    put(B::hi_bx, b.hi_b.x), put(B::hi_by, b.hi_b.y);
    put(B::length, c.length), put(B::ratio, c.ratio);
    put(B::damping, c.damping), put(B::squeeze, c.squeeze);
    blocks.back().lo[lane & 3] = lo;
    blocks.back().hi[lane & 3] = hi;
    rests.back().crack_a[lane & 3] = b.crack_a;
    rests.back().crack_b[lane & 3] = b.crack_b;
    rests.back().share[lane & 3] = share;
  }
  places.push_back(place);
}

void BondRecords::crack(int k, double a, double b) {
  rests[k >> 2].crack_a[k & 3] = a;
  rests[k >> 2].crack_b[k & 3] = b;
  plain[k >> 2] = false;
}

void BondRecords::remove(int k) {
  at(BondBlock::ratio, k) = at(BondBlock::damping, k) = 0.0;
  at(BondBlock::squeeze, k) = std::numeric_limits<double>::max();
  crack(k, 0.0, 0.0);
  rests[k >> 2].share[k & 3] = 0.0;
  block(k).hi[k & 3] = block(k).lo[k & 3];
  places[k] = {nullptr, nullptr};
}

void ContactRecords::clear() {
  ends.clear();
  rows.clear();
  ridges.clear();
  covers.clear();
  places.clear();
}

}  // namespace floe
