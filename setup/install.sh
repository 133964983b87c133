#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# Sets FloeFlow up, doing only what is not done yet: packages of the distribution, a Python
# environment in .venv from the lock, the plugin for LIGGGHTS in build/. Asked for by `make setup`.
# Everything that can be refused is refused, in one sentence and with exit code 1, before anything
# is changed. Reads PYTHON=, LIGGGHTS_ROOT= and NO_APT=1 (docs/install.md).
set -euo pipefail
# shellcheck source=setup/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

# ---- packages of the distribution ------------------------------------------------------------

candidate() { LC_ALL=C apt-cache policy "$1" 2>/dev/null | sed -n 's/^  Candidate: //p'; }
known() { local c && c=$(candidate "$1") && [[ -n $c && $c != "(none)" ]]; }

all_known() {
    local package
    for package in "$@"; do known "$package" || return 1; done
}

check_candidates() { # packages
    local package
    for package in "$@"; do
        known "$package" && continue
        [[ $package != *liggghts* ]] ||
            fail "LIGGGHTS is not in this distribution (apt knows no package $package; Debian 12" \
                "and Ubuntu 24.04 have it): build LIGGGHTS 3.8.0 from source and name its folder" \
                "with LIGGGHTS_ROOT=/path/to/it."
        fail "apt knows no package $package, which FloeFlow needs: enable the part of the" \
            "distribution that has it, or install it by hand."
    done
}

install_packages() {
    local missing=() as_root=() version
    mapfile -t missing < <(missing_packages)
    ((${#missing[@]})) || return 0

    local list="${missing[*]}" own=""
    [[ $list != *liggghts* ]] ||
        own="; a LIGGGHTS 3.8.0 built from source is named with LIGGGHTS_ROOT="
    [[ ${NO_APT:-} != 1 ]] ||
        fail "these are missing and NO_APT=1 forbids installing them: $list (names of Debian" \
            "packages; install them, or leave NO_APT=1 out$own)."
    command -v apt-get >/dev/null ||
        fail "these are missing and there is no apt-get to install them with: $list (names of" \
            "Debian packages; install what your system calls them, or use Debian 12$own)."
    if (($(id -u))); then
        command -v sudo >/dev/null ||
            fail "these packages are missing and installing them needs root or sudo: ask an" \
                "administrator for: apt-get install $list"
        as_root=(sudo)
    fi

    say "needs these packages of the distribution, and installs them with" \
        "'${as_root[*]}${as_root:+ }apt-get install': $list"
    if ! all_known "${missing[@]}"; then # lists never fetched, or a package that is not there
        "${as_root[@]}" apt-get -qq update || fail "'apt-get update' failed: see its words above."
    fi
    check_candidates "${missing[@]}"
    if [[ $list == *python3-venv* && -z ${PYTHON:-} ]]; then
        version=$(candidate python3 | cut -d. -f1,2)
        check_python "$version" "the distribution's python3"
    fi
    local install=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive
        apt-get -qq install --yes --no-install-recommends "${missing[@]}")
    "${install[@]}" >/dev/null || { # the lists may name versions that are gone
        "${as_root[@]}" apt-get -qq update && "${install[@]}" >/dev/null
    } || fail "'apt-get install $list' failed: see its words above."
    check_interpreter
    mapfile -t missing < <(missing_packages)
    ((!${#missing[@]})) ||
        fail "after 'apt-get install' these are still missing, perhaps hidden by other programs of" \
            "the same name on PATH: ${missing[*]}."
}

check_liggghts_root() {
    local folder
    folder=$(liggghts_root)
    [[ -z $folder || (-n $(liggghts_headers "$folder") && -n $(liggghts_library "$folder")) ]] ||
        fail "LIGGGHTS_ROOT=$folder holds no headers with a libliggghts.so: build LIGGGHTS 3.8.0" \
            "there as a shared library, or leave LIGGGHTS_ROOT out and run 'make clean'."
}

check_interpreter() {
    local python version
    python=$(python_command)
    if ! command -v "$python" >/dev/null; then
        [[ -z ${PYTHON:-} ]] || fail "PYTHON=$PYTHON is no program: name a Python 3.11 to 3.13."
        return 0 # apt brings it
    fi
    version=$(python_version "$python")
    [[ -n $version ]] || fail "PYTHON=$python does not run: name a Python 3.11 to 3.13."
    check_python "$version" "$(command -v "$python")"
    if [[ -n ${PYTHON:-} ]] && ! have module:venv; then
        fail "PYTHON=$PYTHON lacks its module venv or ensurepip: name a complete Python 3.11 to 3.13."
    fi
}

# ---- the Python environment ------------------------------------------------------------------

venv_version() { sed -n 's/^python //p' "$stamp" 2>/dev/null || :; }

install_venv() {
    local python version wanted
    # An environment once made with PYTHON= stays until another PYTHON= is named.
    version=$(venv_version)
    python=$(python_command)
    if [[ -z $version || -n ${PYTHON:-} ]]; then version=$(python_version "$python"); fi
    wanted=$(venv_stamp "$version")
    if [[ $(cat "$stamp" 2>/dev/null) == "$wanted" ]]; then return 0; fi

    # A .venv knows its own path, so it is made in its place. The one there was comes back if
    # this fails; the stamp, written last, tells a complete one from what a kill left behind.
    if [[ -z ${PYTHON:-} && -x $venv/bin/python && -f $stamp ]]; then
        python=$("$venv/bin/python" -c 'import sys; print(sys._base_executable)') || python=python3
    fi
    say "makes .venv with Python $version from $lock"
    rm -rf "$venv.old"
    if [[ -f $stamp ]]; then mv "$venv" "$venv.old"; else rm -rf "$venv"; fi
    trap 'restore_venv' EXIT
    "$python" -m venv "$venv"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check \
        --no-deps --require-hashes --only-binary :all: -r "$lock" ||
        fail "Python packages could not be installed (pip's words are above): .venv is as before."
    printf '%s\n' "$wanted" >"$stamp"
    trap - EXIT
    rm -rf "$venv.old"
}

restore_venv() {
    rm -rf "$venv"
    if [[ -d $venv.old ]]; then mv "$venv.old" "$venv"; fi
}

# Folders whose sources moved away keep what Python compiled of them, and Python would still import
# them, as packages without a source.
sweep() {
    local folder cache
    for folder in floeflow preprocess simulate postprocess studies benchmarks tests; do
        [[ -d $folder ]] || continue
        while IFS= read -r -d '' cache; do
            compgen -G "${cache%/*}/*.py" >/dev/null || rm -rf "$cache"
        done < <(find "$folder" -type d -name __pycache__ -print0)
        find "$folder" -mindepth 1 -type d -empty -delete
    done
}

# The project itself, editable: a new module is seen at once, a changed pyproject.toml is not.
install_project() {
    local mark=$venv/floeflow-project sum
    sum=$(sha256sum <pyproject.toml)
    if [[ $(cat "$mark" 2>/dev/null) == "$sum" ]]; then return 0; fi
    rm -rf floeflow.egg-info "$venv"/lib/python*/site-packages/__editable__*floeflow*
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check \
        --no-deps --no-build-isolation --editable . ||
        fail "the packages of pyproject.toml could not be installed (pip's words are above)."
    printf '%s\n' "$sum" >"$mark"
}

# ---- the plugin ------------------------------------------------------------------------------

build_plugin() {
    local source cached home own=()
    source=$(liggghts_root)
    if [[ -n $source ]]; then
        own=("-DLIGGGHTS_ROOT=$source" "-DLIGGGHTS_INCLUDE=$(liggghts_headers "$source")"
            "-DLIGGGHTS_LIBRARY=$(liggghts_library "$source")/libliggghts.so")
    fi
    if [[ -f $plugin/CMakeCache.txt ]]; then
        cached=$(sed -n 's/^LIGGGHTS_ROOT:[A-Z]*=//p' "$plugin/CMakeCache.txt")
        home=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$plugin/CMakeCache.txt")
        if [[ $cached != "$source" || $home != "$root/liggghts_models" ]]; then rm -rf "$plugin"; fi
    fi
    mkdir -p build
    if [[ ! -f $plugin/CMakeCache.txt ]]; then
        say "configures the plugin in $plugin"
        cmake -S liggghts_models -B "$plugin" -DCMAKE_BUILD_TYPE=Release \
            "${own[@]}" >build/plugin.log 2>&1 || {
            rm -rf "$plugin" # a cache half written would be taken for a good one
            plugin_failed
        }
    fi
    cmake --build "$plugin" --parallel 2 >build/plugin.log 2>&1 || plugin_failed
}

plugin_failed() {
    tail -n 40 build/plugin.log >&2
    fail "the plugin could not be built (above is the end of build/plugin.log)."
}

# ---- in this order ---------------------------------------------------------------------------

mkdir -p build
exec 9>build/setup.lock
flock 9 # two makes at once: the second waits, and then finds everything done
check_interpreter
check_liggghts_root
install_packages
install_venv
sweep
install_project
build_plugin
