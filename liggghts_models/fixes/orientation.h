// SPDX-License-Identifier: GPL-2.0-or-later
#ifndef FLOE_FIXES_ORIENTATION_H
#define FLOE_FIXES_ORIENTATION_H

namespace floe {

// Writes cosine and sine of each angle (rad) into a row of two.
void write_turns(const double *angle, int count, double *rows);

}  // namespace floe

#endif
