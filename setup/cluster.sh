#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# Puts Snakemake's plugins for clusters into .venv, from their lock. With --slurm also installs
# Debian's Slurm, for the tests on a private one (as root; never asked for by `make test`).
set -euo pipefail
# shellcheck source=setup/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

packages=(slurmctld slurmd slurm-client munge)

[[ -x $venv/bin/python ]] || fail "there is no .venv yet: run 'make setup' first."
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes \
    --only-binary :all: -r setup/requirements-cluster.lock || {
    # The tests say why they skip.
    words="the plugins for clusters could not be installed (pip's words are above)"
    [[ ${1:-} == --slurm ]] || fail "$words."
    say "$words: cluster tests will skip."
}

[[ ${1:-} == --slurm ]] || exit 0
missing=()
for package in "${packages[@]}"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q ' installed$' || missing+=("$package")
done
((${#missing[@]})) || exit 0
if [[ $(id -u) != 0 || ${NO_APT:-} == 1 ]] || ! command -v apt-get >/dev/null; then
    say "cannot install ${missing[*]} here (not root, no apt-get, or NO_APT=1): cluster tests will skip."
    exit 0
fi
say "installs for the cluster tests: ${missing[*]}"
# A mirror that does not answer must not hold the tests up.
apt=(env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300
    -o Acquire::http::Timeout=20 -o Acquire::https::Timeout=20 -o Acquire::Retries=1)
install=("${apt[@]}" install --yes --no-install-recommends "${missing[@]}")
"${install[@]}" >/dev/null 2>&1 || { "${apt[@]}" update && "${install[@]}" >/dev/null; } ||
    say "'apt-get install ${missing[*]}' failed (its words are above): cluster tests will skip."
