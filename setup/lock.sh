#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# Pins the direct dependencies of requirements*.in, and all they need, in requirements.lock, and
# those of clusters in requirements-cluster.lock, and those of the docs in requirements-docs.lock: one version of each for Python 3.11 to 3.13, with hashes, wheels only, no index address.
# Needs uv: the one on PATH, else one installed from PyPI under build/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if command -v uv >/dev/null; then
    uv=uv
else
    uv=build/uv/bin/uv
    if [[ ! -x $uv ]]; then
        "${PYTHON:-python3}" -m venv build/uv
        build/uv/bin/pip install --quiet uv
    fi
fi

new=$(mktemp build/requirements.XXXXXX)
trap 'rm -f "$new"' EXIT

# Write the lock of some lists. Versions stay as they are where they still suit; UPGRADE=1 takes the
# newest of all.
pin() { # lock, options and lists for uv
    local lock=$1
    shift
    : >"$new"
    [[ -n ${UPGRADE:-} || ! -f $lock ]] || cp "$lock" "$new"
    "$uv" pip compile --quiet --universal --python-version 3.11 --fork-strategy fewest \
        ${UPGRADE:+--upgrade} --generate-hashes --only-binary :all: --no-emit-index-url \
        --no-emit-find-links --no-header --output-file "$new" "$@"
    {
        echo "# Written by \`make lock\` from setup/requirements*.in: do not edit."
        # The platform was the condition of the whole resolution (pyproject.toml, tool.uv): said of
        # every line it would make pip skip every line elsewhere instead of failing.
        sed -e "s/python_full_version < '3.14' and platform_machine == 'x86_64' and//" \
            -e "s/ ;  *sys_platform == 'linux'//" \
            -e "s/  *sys_platform == 'linux' and//" \
            -e "s/;  */; /" "$new"
    } >"$lock"
}

pin setup/requirements.lock setup/requirements.in setup/requirements-workflow.in \
    setup/requirements-formats.in setup/requirements-movies.in setup/requirements-dev.in
# All that the cluster's plugins need is in the first lock.
pin setup/requirements-cluster.lock --no-deps --constraints setup/requirements.lock \
    setup/requirements-cluster.in
# The site has a .venv of its own, with the versions of the first lock where both have a package.
pin setup/requirements-docs.lock --constraints setup/requirements.lock setup/requirements-docs.in
