#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# Builds the site of the documentation in build/site, in a .venv of its own: any warning fails.
# The pages load nothing from the network; opened as files all works but the search, which needs a
# server: python3 -m http.server -d build/site
set -euo pipefail
# shellcheck source=setup/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
site=$root/build/docs

[[ -x $site/bin/python ]] || "$venv/bin/python" -m venv "$site"
if ! cmp -s setup/requirements-docs.lock "$site/lock"; then
    "$site/bin/python" -m pip install --quiet --disable-pip-version-check --no-deps \
        --require-hashes --only-binary :all: -r setup/requirements-docs.lock ||
        fail "the packages of the site could not be installed (pip's words are above)."
    cp setup/requirements-docs.lock "$site/lock"
fi
# Material tells of a successor of MkDocs on every build; that is no warning of ours.
NO_MKDOCS_2_WARNING=1 "$site/bin/mkdocs" build --quiet --strict --site-dir build/site
loads='<(script|img|iframe)[^>]* src="https?:|<link[^>]* rel="(stylesheet|preconnect|icon)"[^>]* href="https?:'
if grep -rlE "$loads" build/site --include='*.html' | head -3 | grep .; then
    fail "these pages load something from the network."
fi
say "the site: build/site/index.html"
