#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# Runs every test but the slow ones. Those of a single process run in two parts side by side; those
# that start MPI or Snakemake run after them, alone: ranks that share their cores with others wait
# for each other at every step.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1

run() { .venv/bin/python -m pytest "$@" tests; }
short="not slow and not browser and not cluster"
single="$short and not mpi and not workflow"
mkdir -p build
second=$(mktemp build/tests.XXXXXX)
trap 'kill "$other" 2>/dev/null; rm -f "$second"' EXIT

code=0
run -m "$single" --part 2/2 -o cache_dir=build/cache/pytest-2 >"$second" 2>&1 &
other=$!
run -m "$single" --part 1/2 || code=$?
wait "$other" || code=$?
cat "$second"
run -m "$short and (mpi or workflow)" || code=$?
exit "$code"
