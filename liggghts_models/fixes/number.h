// SPDX-License-Identifier: GPL-2.0-or-later
//
// Numbers of commands. LIGGGHTS' own reader ends with a sentence that does not name the keyword.
#ifndef FLOE_FIXES_NUMBER_H
#define FLOE_FIXES_NUMBER_H

#include <cmath>
#include <cstdlib>

namespace floe {

// What is wrong with a word that should be a finite number, to stand behind its keyword; else null.
inline const char *number_fault(const char *word, double &value) {
  char *end = nullptr;
  value = std::strtod(word, &end);
  if (end == word || *end != '\0') return " must be a number";
  return std::isfinite(value) ? nullptr : " is not finite";
}

}  // namespace floe

#endif
