// SPDX-License-Identifier: GPL-2.0-or-later
//
// Seeded numbers for tests, the same on every machine.
#ifndef FLOE_TESTS_RANDOM_H
#define FLOE_TESTS_RANDOM_H

#include <random>

struct Uniform {
  std::mt19937_64 engine;
  explicit Uniform(unsigned seed) : engine(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * (engine() >> 11) * 0x1p-53;
  }
};

#endif
