// SPDX-License-Identifier: GPL-2.0-or-later
//
// What the loop over pairs reads and writes for each pair, packed densely in the order in which it is
// read. The records live as long as the neighbour lists; LIGGGHTS' own history (history.h), which
// it carries from list to list and between ranks, is read when they are made and written when they go.
#ifndef FLOE_CONTACT_RECORDS_H
#define FLOE_CONTACT_RECORDS_H

#include <cstddef>
#include <vector>

#include "bond.h"
#include "contact.h"
#include "large_pages.h"
#include "ridge.h"

namespace floe {

// Where LIGGGHTS keeps the history of a pair.
struct Place {
  double *history;
  int *flag;
};

// Four bonds, column by column, as packs read them: what every step needs of every bond.
struct alignas(32) BondBlock {
  enum Column {
    lo_ax,
    lo_ay,
    lo_bx,
    lo_by,
    hi_ax,
    hi_ay,
    hi_bx,
    hi_by,
    length,
    ratio,
    damping,
    squeeze,
    column_count
  };
  double column[column_count][4];
  int lo[4], hi[4];  // elements with the lower and the higher id
};

// What most bonds do not need: where all four are whole and met by one rank only, it is not read.
struct alignas(32) BondRest {
  double crack_a[4], crack_b[4];  // cracked shares of the line
  double share[4];                // 1, or 1/2 for a pair that two ranks meet
};

// The same of all blocks that are plain: it stays in the cache.
constexpr BondRest plain_rest{{}, {}, {1.0, 1.0, 1.0, 1.0}};

struct BondRecords {
  int count = 0;
  LongArray<BondBlock> blocks;
  LongArray<BondRest> rests;
  std::vector<char> plain;    // of each block: all whole, all met by one rank
  std::vector<Place> places;  // history is null where the bond has broken

  void clear();
  void add(int lo, int hi, double share, const BondShape &, const BondConstants &, Place);
  // Nothing is left of bond k: it stays in its block, without force, until the lists are made anew.
  void remove(int k);
  BondBlock &block(int k) { return blocks[k >> 2]; }
  double &at(BondBlock::Column column, int k) { return blocks[k >> 2].column[column][k & 3]; }
  const BondRest &rest(int k) const { return plain[k >> 2] ? plain_rest : rests[k >> 2]; }
  double crack_a(int k) const { return rests[k >> 2].crack_a[k & 3]; }
  double crack_b(int k) const { return rests[k >> 2].crack_b[k & 3]; }
  double share(int k) const { return rests[k >> 2].share[k & 3]; }
  void crack(int k, double a, double b);
};

// A pair that is not bonded, as listed: the sign of j's bits says whether it has a contact.
struct Ends {
  static constexpr int mark = ~0x7fffffff;
  int i, marked_j;
  int j() const { return marked_j & ~mark; }
  bool touching() const { return marked_j < 0; }
};

struct alignas(32) ContactRow {
  double slip, rest, stiffness, damping;  // m, m, N/m, N s/m
};

struct alignas(32) RidgeRow {
  double closing, thickness, length, limit;  // m, m, m; force at which it closes, N
};

// Batches read them as four columns in this order (contact_batch.cpp).
static_assert(offsetof(ContactRow, slip) == 0 && offsetof(ContactRow, rest) == 8 &&
              offsetof(ContactRow, stiffness) == 16 && offsetof(ContactRow, damping) == 24);
static_assert(offsetof(RidgeRow, closing) == 0 && offsetof(RidgeRow, limit) == 24);

// What a step moves: benchmarks/roofline.py counts with these.
static_assert(sizeof(BondBlock) == 4 * 104 && sizeof(Ends) == 8 && sizeof(ContactRow) == 32);

struct ContactRecords {
  LongArray<Ends> ends;
  LongArray<ContactRow> rows;
  LongArray<RidgeRow> ridges;  // with ridging only, as the next
  LongArray<double> covers;    // share of ice between the centres
  std::vector<Place> places;

  void clear();
  void add_ridge() {
    ridges.push_back({});
    covers.push_back(1.0);
  }
  Ridge ridge(int k) const {
    return {ridges[k].closing, ridges[k].thickness, ridges[k].length, covers[k]};
  }
};

}  // namespace floe

#endif
