# SPDX-License-Identifier: GPL-2.0-or-later
"""What the Snakefile and the scripts of its rules share: opening a run, running a job."""
