// SPDX-License-Identifier: GPL-2.0-or-later
#include "records.h"

#include <limits>

namespace floe {

void BondRecords::clear() {
  count = 0;
  blocks.clear();
  places.clear();
}

void BondRecords::add(int lo, int hi, double share, const BondShape &b, const BondConstants &c,
                      Place place) {
  const int k = count++;
  // The lanes behind the last bond hold copies of the block's first, which are not counted.
  const int last = k % 4 == 0 ? k + 4 : k + 1;
  if (k % 4 == 0) blocks.emplace_back();
  for (int lane = k; lane < last; ++lane) {
    const double values[BondBlock::column_count] = {
        b.lo_a.x,  b.lo_a.y,  b.lo_b.x, b.lo_b.y, b.hi_a.x,  b.hi_a.y,  b.hi_b.x, b.hi_b.y,
        b.crack_a, b.crack_b, c.length, c.ratio,  c.damping, c.squeeze, share};
    for (int column = 0; column < BondBlock::column_count; ++column) {
      blocks.back().column[column][lane & 3] = values[column];
    }
    blocks.back().lo[lane & 3] = lo;
    blocks.back().hi[lane & 3] = hi;
  }
  places.push_back(place);
}

void BondRecords::remove(int k) {
  at(BondBlock::ratio, k) = at(BondBlock::damping, k) = at(BondBlock::share, k) = 0.0;
  at(BondBlock::crack_a, k) = at(BondBlock::crack_b, k) = 0.0;
  at(BondBlock::squeeze, k) = std::numeric_limits<double>::max();
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
