#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# Runs the scene `smoke` through both cluster profiles, on a private Slurm that ends with it. The
# second profile makes the windows anew, and what follows from them.
set -euo pipefail
# shellcheck source=setup/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

folder=$(mktemp -d)
trap 'setup/private_slurm.sh stop "$folder"; rm -rf "$folder"' EXIT
setup/private_slurm.sh start "$folder"
# shellcheck source=/dev/null
source "$folder/env.sh"
sinfo

run() { # profile, more options
    local profile=$1
    shift
    say "runs smoke through workflows/profiles/$profile"
    "$venv/bin/snakemake" --profile "workflows/profiles/$profile" --latency-wait 10 "$@" \
        --config scene=config/scenes/smoke.yaml
}
run cluster-generic --seconds-between-status-checks=1
# Finished windows would be taken, and no rank would start.
rm -rf results/smoke/.windows
run slurm --forcerun windows --slurm-init-seconds-before-status-checks=1 \
    --slurm-status-command=squeue

say "Slurm's own record of these jobs:"
sed -E 's/^JobId=([0-9]+) .* Name=(\S+) JobState=(\S+) .* NodeList=(\S+) .* ProcCnt=(\S+) .*/\1 \2 \3 on \4, \5 tasks/' \
    "$folder/completed.txt"
