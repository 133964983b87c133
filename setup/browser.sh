#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# Chromium for `make test-browser`, from the distribution if it is missing: nothing else needs it,
# so that it is not in apt-packages.txt. NO_APT=1 forbids installing it.
set -euo pipefail
# shellcheck source=setup/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

if command -v chromium >/dev/null || command -v chromium-browser >/dev/null; then exit 0; fi
[[ ${NO_APT:-} != 1 ]] ||
    fail "chromium is missing, which the tests in a browser need, and NO_APT=1 forbids installing it."
command -v apt-get >/dev/null ||
    fail "chromium is missing, which the tests in a browser need, and there is no apt-get."
as_root=()
if (($(id -u))); then
    command -v sudo >/dev/null ||
        fail "chromium is missing and installing it needs root or sudo: apt-get install chromium"
    as_root=(sudo)
fi
say "the tests in a browser need chromium, and install it with apt-get"
"${as_root[@]}" apt-get -qq update
DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get -qq install -y --no-install-recommends chromium >/dev/null
