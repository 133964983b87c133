# SPDX-License-Identifier: GPL-2.0-or-later
# shellcheck shell=bash
# What install.sh, doctor.sh and lint.sh share. To be sourced; leaves the caller in the project.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
cd "$root"

lock=setup/requirements.lock
venv=.venv
stamp=$venv/floeflow-stamp # written last: a .venv without it is not complete
plugin=build/liggghts_models
include=/usr/include

say() { printf 'FloeFlow: %s\n' "$*" >&2; }
fail() {
    printf 'FloeFlow: %s\n' "$*" >&2
    exit 1
}

# The interpreter to build .venv with: PYTHON= or else python3.
python_command() { echo "${PYTHON:-python3}"; }

# "3.11" of an interpreter; nothing when it does not run.
python_version() { "$1" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null || :; }

# Ends with a sentence unless the version "3.x" is one the lock is made for.
check_python() { # version, where it was found
    local minor=${1#3.}
    local select="select another interpreter with PYTHON=/path/to/python3.11"
    [[ $1 == 3.* && ${minor%%.*} -ge 11 ]] ||
        fail "Python $1 ($2) is older than 3.11, the oldest that FloeFlow runs with: $select."
    [[ ${minor%%.*} -le 13 ]] ||
        fail "Python $1 ($2) is newer than 3.13, the newest that FloeFlow is pinned for: $select."
}

# LIGGGHTS_ROOT as given, else as the plugin was last built with, else empty.
liggghts_root() {
    if [[ -n ${LIGGGHTS_ROOT:-} ]]; then
        echo "$LIGGGHTS_ROOT"
    elif [[ -f $plugin/CMakeCache.txt ]]; then
        sed -n 's/^LIGGGHTS_ROOT:[A-Z]*=//p' "$plugin/CMakeCache.txt"
    fi
}

# The folder of LIGGGHTS' headers and that of its library, for one built from source or, with an
# empty argument, for the distribution's. Nothing where there is none.
liggghts_headers() {
    if [[ -z $1 ]]; then ls -d "$include/liggghts"; else find_folder "$1" granular_pair_style.h; fi
}
liggghts_library() {
    if [[ -z $1 ]]; then
        "${CXX:-g++}" -print-file-name=libliggghts.so | sed -n 's#\(.*/\).*#\1#p'
    else
        find_folder "$1" libliggghts.so
    fi
}
find_folder() {
    find -L "$1" -maxdepth 4 -name "$2" -printf '%h\n' 2>/dev/null | sort | head -n 1
}

have() { # how a package of apt-packages.txt is told
    case $1 in
    command:*) command -v "${1#*:}" >/dev/null ;;
    header:*) [[ -e $include/${1#*:} ]] ;;
    module:*) "$(python_command)" -c "import ${1#*:}, ensurepip" 2>/dev/null ;;
    esac
}

# Every package that is missing, one a line.
missing_packages() {
    local package told rest source
    source=$(liggghts_root)
    while read -r package told rest; do
        [[ $package == \#* || -z $package ]] && continue
        [[ $rest == source* && -n $source ]] && continue
        have "$told" || echo "$package"
    done <setup/apt-packages.txt
}

# What .venv must have been made from to be kept: a change of any of it means a new one.
venv_stamp() { # version of Python
    printf 'place %s\npython %s\nlock %s\n' "$root" "$1" "$(sha256sum <"$lock" | cut -c1-64)"
}
