#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# Runs every test but the slow ones, in two processes side by side: one begins with the first module,
# the other with the last, until they meet. At the end one line tells what was skipped for want of
# reference data.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1

beside=$(mktemp -d "${TMPDIR:-/tmp}/floeflow-tests.XXXXXX")
trap 'kill "$other" 2>/dev/null; rm -rf "$beside"' EXIT

# Ranks of MPI wait for each other thousands of times a second. While the other process has a core,
# a rank that shares it makes its peers wait for whole slices of time; ranks that share one core hand
# it on at once. So on few cores the ranks of each process keep to one core, where Open MPI can.
core=OMPI_MCA_hwloc_base_cpu_list
few=no
if (($(nproc) < 4)); then
    few=yes
    for number in 0 1; do
        env "$core=$number" mpirun --allow-run-as-root --oversubscribe -n 2 true &>/dev/null || few=no
    done
fi

# Threads of BLAS would wait, spinning, for the core that the other process has.
export OPENBLAS_NUM_THREADS=1

run() { # name of the process, core of its ranks, more options
    local name=$1 number=$2
    shift 2
    [[ $few == no ]] || export "$core=$number"
    .venv/bin/python -m pytest -m "not slow and not browser and not cluster" --durations=15 \
        --beside "$beside" -o cache_dir="build/cache/pytest-$name" "$@" tests
}

code=0
run 2 1 --backwards >"$beside/second" 2>&1 &
other=$!
run 1 0 | tee "$beside/first" || code=$?
wait "$other" || code=$?
cat "$beside/second"
awk '/^SKIPPED \[[0-9]+\] .*: no reference data/ { gsub(/[^0-9]/, "", $2); absent += $2 }
    END { print "FloeFlow: " absent + 0 " tests were skipped because reference data are absent" \
        (absent ? " (make verification needs them: docs/verification/contact.md)" : "") }' \
    "$beside/first" "$beside/second"
exit "$code"
