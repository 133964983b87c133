#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# The checks of `make lint`: all of them, or those named: setup/lint.sh types cpp
# Each is a function check_*; every one runs, and at the end those that failed are named.
set -uo pipefail
# shellcheck source=setup/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
bin=$root/$venv/bin

check_ruff() { "$bin/ruff" check --quiet . && "$bin/ruff" format --quiet --check --diff .; }

check_snakefiles() { "$bin/snakefmt" --check --compact-diff Snakefile workflows; }

check_types() {
    "$bin/mypy" --no-error-summary --cache-dir "$root/build/cache/mypy" --package floeflow
}

# Layers of the library: what may import what, imports inside of functions counted.
check_imports() { "$bin/lint-imports" --no-cache >build/imports.log 2>&1 || { cat build/imports.log; false; }; }

check_cpp() {
    find liggghts_models setup -name '*.cpp' -o -name '*.h' -o -name '*.hpp' | sort |
        xargs "$bin/clang-format" --dry-run --Werror
}

check_workflow() { "$bin/python" setup/lint_workflow.py "$bin/snakemake"; }

check_config() { "$bin/floeflow" docs >/dev/null; }

check_shell() {
    local script failed=0
    for script in setup/*.sh .ci/run; do bash -n "$script" || failed=1; done
    return $failed
}

check_licence() {
    local without
    without=$(git ls-files -co --exclude-standard -- '*.py' '*.sh' '*.cpp' '*.h' '*.hpp' '*.smk' \
        Snakefile Makefile .ci/run | xargs -r -d '\n' awk '
            FNR <= 2 && /SPDX-License-Identifier: GPL-2.0-or-later/ { seen[FILENAME] = 1 }
            FNR == 1 { all[FILENAME] = 1 }
            END { for (file in all) if (!(file in seen)) print file }')
    [[ -z $without ]] && return 0
    printf 'no SPDX line at the top of: %s\n' "$without"
    return 1
}

# Two at a time; what each said comes in order, when all have ended.
all=(types ruff snakefiles imports cpp workflow config shell licence)
checks=("${@:-${all[@]}}")
said=$(mktemp -d)
trap 'rm -rf "$said"' EXIT
for check in "${checks[@]}"; do
    while (($(jobs -rp | wc -l) > 1)); do wait -n; done
    { "check_$check" || touch "$said/$check.failed"; } >"$said/$check" 2>&1 &
done
wait
failed=()
for check in "${checks[@]}"; do
    cat "$said/$check"
    [[ ! -e $said/$check.failed ]] || failed+=("$check")
done
((${#failed[@]} == 0)) || fail "lint failed: ${failed[*]} (again alone: setup/lint.sh ${failed[*]})."
