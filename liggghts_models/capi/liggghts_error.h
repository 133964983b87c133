// SPDX-License-Identifier: GPL-2.0-or-later
//
// Errors of LIGGGHTS as exceptions. The library ends the process when all ranks meet an error; inside
// the plugin such an error becomes an exception, so that Python can say what was wrong and go on.
#ifndef FLOE_LIGGGHTS_ERROR_H
#define FLOE_LIGGGHTS_ERROR_H

#include <exception>
#include <stdexcept>
#include <string>

namespace floe {

struct LiggghtsError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

std::string &last_error();

// Runs work; 0, or 1 with the reason in last_error(). No exception crosses the C interface: every
// function of it is one of these two (tests/unit/dynamics/test_plugin.py holds them to it).
template <typename Work>
int guarded(Work work) noexcept {
  try {
    work();
    return 0;
  } catch (const std::exception &error) {
    last_error() = error.what();
  } catch (...) {
    last_error() = "an error without words";
  }
  return 1;
}

// The number that work gives, -1 with the reason in last_error().
template <typename Work>
long long counted(Work work) noexcept {
  long long number = 0;
  return guarded([&] { number = work(); }) ? -1 : number;
}

}  // namespace floe

#endif
