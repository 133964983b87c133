#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# Proves the two commands where nothing of FloeFlow's is: makes a bare Debian 12 in a folder, or the
# release that SUITE= names (trixie), puts git, make and a clone of the last commit into it, and there runs `make run`, `make run` again,
# which must do nothing, and `make test`. Prints what each took. Needs root, mmdebstrap and 4 GB
# under TMPDIR; KEEP=1 leaves the folder. The host's own ways to the network go along: resolv.conf,
# apt's sources and proxies, pip's configuration, certificates.
set -euo pipefail
# shellcheck source=setup/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

bundle=/etc/ssl/certs/ca-certificates.crt
project=/root/floeflow
suite=${SUITE:-bookworm}

# ---- inside a mount namespace of its own: whatever ends this, its mounts end with it ------------

in_chroot() { # command
    local variable passed=()
    for variable in PIP_INDEX_URL PIP_EXTRA_INDEX_URL PIP_TRUSTED_HOST PIP_PROXY PIP_RETRIES \
        PIP_DEFAULT_TIMEOUT http_proxy https_proxy no_proxy HTTP_PROXY HTTPS_PROXY NO_PROXY; do
        [[ -z ${!variable:-} ]] || passed+=("$variable=${!variable}")
    done
    if compgen -G '/usr/local/share/ca-certificates/*' >/dev/null; then
        passed+=("PIP_CERT=$bundle" "SSL_CERT_FILE=$bundle" "REQUESTS_CA_BUNDLE=$bundle")
    fi
    chroot "$fresh" /usr/bin/env -i HOME=/root LANG=C.UTF-8 TERM=dumb "${passed[@]}" \
        PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
        /bin/bash -c "cd $project 2>/dev/null || cd /; $1" </dev/null
}

timed() { # what to call it, command
    local start=$SECONDS
    say "in the bare Debian: $1"
    in_chroot "$2" || fail "'$1' failed in the bare Debian after $((SECONDS - start)) s."
    times+=("$(printf '%6d s  %s' $((SECONDS - start)) "$1")")
}

# Everything that a run makes, with the time of its last change; CMake tidies its lists of headers
# when it is asked whether there is anything to do.
made() {
    (cd "$fresh$project" && find results build -type f ! -name '*.log' ! -name '*lock' \
        ! -name 'compiler_depend.*' \
        -printf '%p %T@\n' | sort)
}

inside() {
    local folder program first times=()
    for folder in proc sys dev; do mount --rbind "/$folder" "$fresh/$folder"; done
    for program in python3 gcc g++ cc cmake mpirun; do
        ! in_chroot "command -v $program" || fail "the bare Debian has $program already."
    done
    in_chroot "update-ca-certificates >/dev/null 2>&1"

    timed "make run" "make run"
    first=$(made)
    timed "make run, again" "make run"
    diff <(echo "$first") <(made) || fail "the second 'make run' changed the files above."
    timed "make test" "make test"
    say "works from nothing:"
    printf '%s\n' "${times[@]}"
}

# ---- outside --------------------------------------------------------------------------------

get_mmdebstrap() {
    command -v mmdebstrap >/dev/null && return
    [[ ${NO_APT:-} != 1 ]] || fail "mmdebstrap is missing and NO_APT=1 forbids installing it."
    say "installs mmdebstrap with 'apt-get install'"
    apt-get -qq install --yes --no-install-recommends mmdebstrap >/dev/null ||
        fail "mmdebstrap could not be installed: it comes with Debian and Ubuntu."
}

# The host's sources where they are of the same Debian, else those that mmdebstrap knows.
sources() {
    local file
    for file in /etc/apt/sources.list.d/debian.sources /etc/apt/sources.list; do
        if grep -q -s -E "^[^#]*$suite" "$file"; then
            echo "$file"
            return
        fi
    done
}

make_debian() {
    local from
    from=$(sources)
    apt-config dump | grep -E '^Acquire::(https?::|ForceIPv|Retries|Check-)' >"$fresh.apt" || :
    mmdebstrap --quiet --mode=root --variant=apt --include=git,make,ca-certificates \
        --aptopt="$fresh.apt" "$suite" "$fresh" ${from:+"$from"} ||
        fail "mmdebstrap could not make a Debian ($suite) in $fresh."
}

copy_file() { # from the host, to the bare Debian
    [[ ! -f $1 ]] || install -D -m 644 "$1" "$fresh$2"
}

take_along() {
    copy_file /etc/resolv.conf /etc/resolv.conf
    copy_file /etc/hosts /etc/hosts
    copy_file /etc/pip.conf /etc/pip.conf
    copy_file ~/.config/pip/pip.conf /root/.config/pip/pip.conf
    copy_file "${PIP_CONFIG_FILE:-}" /root/.pip/pip.conf
    mkdir -p "$fresh/usr/local/share/ca-certificates"
    cp -rL /usr/local/share/ca-certificates/. "$fresh/usr/local/share/ca-certificates/"
    git clone --quiet --no-local "$root" "$fresh$project"
}

outside() {
    ((!$(id -u))) || fail "'make test-fresh' needs root: run it with sudo."
    get_mmdebstrap
    [[ -z $(git status --porcelain) ]] ||
        say "tests the last commit; what is not committed stays out."
    fresh=$(mktemp -d "${TMPDIR:-/tmp}/floeflow-fresh.XXXXXX")
    trap remove EXIT
    chmod 755 "$fresh" # apt fetches as a user of its own
    say "makes a bare Debian ($suite) in $fresh"
    make_debian
    take_along
    unshare --mount --fork --kill-child -- "$root/setup/fresh.sh" inside "$fresh"
}

remove() {
    rm -f "$fresh.apt"
    [[ ${KEEP:-} == 1 ]] || rm -rf --one-file-system "$fresh"
}

if [[ ${1:-} == inside ]]; then
    fresh=$2
    inside
else
    outside
fi
