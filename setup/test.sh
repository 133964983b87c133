#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# Runs every test but the slow ones, in two processes side by side: each takes the next module that
# the other has not taken. Most of the time goes into starting programs of one process; where ranks
# of MPI wait for each other they yield the core. At the end one line tells what was skipped for
# want of reference data.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1

beside=$(mktemp -d "${TMPDIR:-/tmp}/floeflow-tests.XXXXXX")
trap 'kill "$other" 2>/dev/null; rm -rf "$beside"' EXIT
run() { # name of the process
    .venv/bin/python -m pytest -m "not slow and not browser and not cluster" --durations=10 \
        --beside "$beside" -o cache_dir="build/cache/pytest-$1" tests
}

code=0
run 2 >"$beside/second" 2>&1 &
other=$!
run 1 | tee "$beside/first" || code=$?
wait "$other" || code=$?
cat "$beside/second"
awk '/^SKIPPED \[[0-9]+\] .*: no reference data/ { gsub(/[^0-9]/, "", $2); absent += $2 }
    END { print "FloeFlow: " absent + 0 " tests were skipped because reference data are absent" \
        (absent ? " (make verification needs them: docs/verification/contact.md)" : "") }' \
    "$beside/first" "$beside/second"
exit "$code"
