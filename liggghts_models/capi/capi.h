// SPDX-License-Identifier: GPL-2.0-or-later
//
// C interface of the plugin for Python (floeflow/dynamics/engine/engine.py). Functions that can fail return 0 for
// success and else 1, those that count -1; the sentence is then in floe_error(). No exception leaves
// them. All are collective unless they say "local". Arrays are contiguous, with columns in the order
// of floe_layout(); columns.h and contact/history.h say what each is.
#ifndef FLOE_CAPI_H
#define FLOE_CAPI_H

#ifdef __cplusplus
extern "C" {
#endif

const char *floe_error(void);
// Version of this interface, raised whenever a function or an array changes its meaning; Python
// compares it and the columns when it loads the plugin (local).
#define FLOE_INTERFACE 5
int floe_interface(void);
// Columns of the arrays below, separated by blanks, in parts that semicolons separate: elements, bonds,
// contacts, the numbers and columns of faces, and of internal forces (local).
const char *floe_layout(void);
int floe_open(int argc, char **argv, void *comm, void **instance);  // comm: pointer to an MPI_Comm
int floe_close(void *instance);
int floe_command(void *instance, const char *line);
// Columns and rows of the grid of ranks, as shares of the box: 0 first, 1 last, one more than the
// command `processors` made of each. Before elements are created (local).
int floe_divide(void *instance, const double *x, const double *y);
int floe_set_start_time(void *instance, double seconds);  // local

// Elements, one row each.
int floe_create_elements(void *instance, long long n, const long long *id, const signed char *type,
                         const double *columns);
long long floe_count_elements(void *instance);                                             // local
int floe_get_elements(void *instance, long long *id, signed char *type, double *columns);  // local

// Pairs, by (lower id, higher id), one row each. Without ridging the columns of ridges are not read, and
// given as 0. How much of the way between the
// centres ice covers follows from the elements when pairs are put in.
// A pair that is in no neighbour list is not taken in.
int floe_put_pairs(void *instance, long long bonds, const long long *bond_ids, const double *bond,
                   long long contacts, const long long *contact_ids, const double *contact);
int floe_count_pairs(void *instance, long long *bonds, long long *contacts);  // local
int floe_get_pairs(void *instance, long long *bond_ids, double *bond, long long *contact_ids,
                   double *contact);  // local

// What pairs and walls do to each element now, one row each in the order of floe_get_elements: force (N),
// and the sum of arms times forces (N m), xx yy xy, above 0 in tension. Damping is in it.
int floe_internal(void *instance, double *columns);  // local

// Walls (after the command "fix ID all floe/walls"). Faces: ends in m at time 0, velocities in m/s; see
// laws/wall.h. Contacts: ids element face, columns as of contacts between elements. Impulses (N s) and
// forces (N) on the ice: x y of each wall.
int floe_set_walls(void *instance, long long walls, long long n, const long long *integers,
                   const double *columns);
int floe_put_wall_contacts(void *instance, long long n, const long long *ids,
                           const double *columns);
long long floe_count_wall_contacts(void *instance);                           // local
int floe_get_wall_contacts(void *instance, long long *ids, double *columns);  // local
int floe_wall_forces(void *instance, double *impulses, double *forces);       // local

// Forcing on a regular grid, copied. velocity: [time][y][x][wind_u wind_v ocean_u ocean_v]. With
// over_discs floes meet means over their discs; with wind_stress the wind is given as |w| w.
int floe_set_forcing(void *instance, long long nt, long long ny, long long nx, const double *time,
                     double x0, double dx, double y0, double dy, const double *velocity,
                     const double *coriolis, int over_discs, int wind_stress);
// Depth of the sea (m) on the grid of the forcing that was set before, copied: [y][x] (local).
int floe_set_depth(void *instance, const double *depth);

// Sums of this rank: names separated by blanks, and the numbers in that order (local).
const char *floe_sum_names(void);
int floe_sums(void *instance, double *out, int size);

// First fault of this rank (local): integers kind step id partner, numbers x y force_x force_y torque
// speed. Kind 0: none.
int floe_fault(void *instance, long long *integers, double *numbers);

#ifdef __cplusplus
}
#endif

#endif
