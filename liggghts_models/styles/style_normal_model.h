// SPDX-License-Identifier: GPL-2.0-or-later
//
// LIGGGHTS generates this list when it is built and does not install it. Its own headers include it;
// the plugin adds its model at load time and needs no entry here.
