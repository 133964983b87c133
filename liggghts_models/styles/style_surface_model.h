// SPDX-License-Identifier: GPL-2.0-or-later
//
// LIGGGHTS generates this list when it is built and does not install it. Its own headers include it
// and need the default surface model's number.
#ifdef SURFACE_MODEL
SURFACE_MODEL(SURFACE_DEFAULT, default, 0)
#endif
