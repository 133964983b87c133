#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# Says what is there and what is missing, then compiles a probe of the plugin and loads it in
# Python on two ranks. Changes nothing but build/probe. Exit code 1 when anything is missing.
set -uo pipefail
# shellcheck source=setup/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

missing=0
there() { printf '  ok       %-16s %s\n' "$1" "$2"; }
lacks() {
    printf '  MISSING  %-16s %s\n' "$1" "$2"
    missing=$((missing + 1))
}
first_number() { grep -o -m 1 -E '[0-9]+(\.[0-9]+)+' | head -n 1; }

report_tools() {
    local tool
    for tool in git make g++ cmake mpirun mpicxx; do
        if command -v "$tool" >/dev/null; then
            there "$tool" "$("$tool" --version 2>/dev/null | first_number)"
        else
            lacks "$tool" "$(awk -v c="command:$tool" '$2 == c { print "apt package " $1 }' \
                setup/apt-packages.txt)"
        fi
    done
    if [[ -e $include/doctest/doctest.h ]]; then
        there doctest "$include/doctest"
    else
        lacks doctest "apt package doctest-dev"
    fi
}

report_liggghts() {
    local source headers library
    source=$(liggghts_root)
    headers=$(liggghts_headers "$source" 2>/dev/null)
    library=$(liggghts_library "$source" 2>/dev/null)
    if [[ -n $headers ]]; then
        there "LIGGGHTS headers" "$headers"
    else
        lacks "LIGGGHTS headers" "apt package libliggghts-dev, or LIGGGHTS_ROOT="
    fi
    if [[ -n $library ]]; then
        there "LIGGGHTS library" "$(readlink -f "$library/libliggghts.so")"
    else
        lacks "LIGGGHTS library" "apt package libliggghts-dev, or LIGGGHTS_ROOT="
    fi
    if [[ -n $source ]]; then return; fi
    if command -v liggghts >/dev/null; then
        there liggghts "$(command -v liggghts)"
    else
        lacks liggghts "apt package liggghts"
    fi
}

report_python() {
    local python version
    python=$(python_command)
    version=$(python_version "$python")
    if [[ -z $version ]]; then
        lacks "$python" "apt package python3-venv, or PYTHON="
    elif ! (check_python "$version" "$python") 2>/dev/null; then
        lacks "$python" "its version $version is not 3.11 to 3.13: PYTHON= selects another"
    else
        there "$python" "$version"
    fi
    if [[ ! -f $stamp ]]; then
        lacks .venv "not made yet, or not to its end: make setup"
    elif [[ $(cat "$stamp") != "$(venv_stamp "$(sed -n 's/^python //p' "$stamp")")" ]]; then
        lacks .venv "made from another lock or in another place: make setup"
    else
        there .venv "Python $(sed -n 's/^python //p' "$stamp"), $lock"
        there clang-format "$("$venv/bin/clang-format" --version | first_number)"
        there snakemake "$("$venv/bin/snakemake" --version)"
    fi
}

report_built_plugin() {
    if [[ -f $plugin/libfloe.so ]]; then
        there plugin "$plugin/libfloe.so"
    else
        lacks plugin "not built yet: make setup"
    fi
}

report_probe() {
    local source library log=build/probe/log
    if [[ ! -f $stamp ]] || ! command -v mpicxx >/dev/null ||
        ! command -v mpirun >/dev/null; then
        lacks probe "needs what is missing above"
        return
    fi
    source=$(liggghts_root)
    library=$(liggghts_library "$source")
    mkdir -p build/probe
    if ! mpicxx -std=c++17 -O1 -shared -fPIC -Wl,-z,defs -DOMPI_SKIP_MPICXX \
        -I"$(liggghts_headers "$source")" setup/probe/probe.cpp -L"$library" -lliggghts \
        -Wl,-rpath,"$library" -o build/probe/libprobe.so >$log 2>&1; then
        lacks probe "does not compile: see $log"
    elif ! mpirun --allow-run-as-root --oversubscribe -n 2 "$venv/bin/python" \
        setup/probe/probe.py build/probe/libprobe.so >$log 2>&1; then
        lacks probe "does not run: see $log"
    else
        there probe "$(cat $log)"
    fi
}

echo "What FloeFlow needs, and what is here:"
report_tools
report_liggghts
report_python
report_built_plugin
report_probe
if ((missing)); then fail "$missing of the above missing; 'make setup' installs what it can."; fi
