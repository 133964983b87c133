#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# Tags the last commit as v<version> of floeflow/__init__.py. Refuses where CHANGELOG.md does not
# begin with that version and a date, where CITATION.cff names another, where something is not
# committed, and where the tag is there.
set -euo pipefail
# shellcheck source=setup/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

version=$(sed -n 's/^__version__ = "\(.*\)"$/\1/p' floeflow/__init__.py)
first=$(sed -n 's/^## //p' CHANGELOG.md | head -n 1)
date=$(sed -n "s/^$version (\([0-9-]*\))\$/\1/p" <<<"$first")

[[ -n $date ]] ||
    fail "the first section of CHANGELOG.md is '$first', not '$version (date)': give what is" \
        "unreleased the version of floeflow/__init__.py and its date."
grep -q "^version: $version\$" CITATION.cff && grep -q "^date-released: \"$date\"\$" CITATION.cff ||
    fail "CITATION.cff does not name version $version of $date, as CHANGELOG.md does."
[[ -z $(git status --porcelain) ]] || fail "something is not committed: see git status."
! git rev-parse --quiet --verify "refs/tags/v$version" >/dev/null ||
    fail "the tag v$version is there: raise the version in floeflow/__init__.py."
git tag --annotate "v$version" --message "FloeFlow $version"
say "tagged v$version; 'git push origin v$version' publishes it."
