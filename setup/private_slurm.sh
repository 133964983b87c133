#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-2.0-or-later
# A private Slurm of two nodes on this one host, to try the cluster profiles without a cluster:
#   setup/private_slurm.sh start DIR     then:  source DIR/env.sh
#   setup/private_slurm.sh stop DIR
# As root; daemons by hand, no systemd, loopback only, free ports, a munge socket and key of its own.
# The nodes need folders of their own for PMIx, else a step over both fails.
# Nothing of a Slurm that this host may have is read or changed. NODE_CPUS=2, NODE_MB=8000,
# PARTITION_MINUTES=60 and TASKS_AT_ONCE set sizes.
set -euo pipefail
fail() {
    printf 'FloeFlow: %s\n' "$*" >&2
    exit 1
}

action=${1:-} D=${2:-}
[[ $D == /* && ($action == start || $action == stop) ]] ||
    fail "usage: setup/private_slurm.sh start|stop /absolute/folder"

# Ends the daemons that this script started in the folder, and those alone: the ids are theirs only
# while the program of that id has the folder on its command line.
stop() {
    local id ids=()
    [[ -f $D/env.sh ]] || return 0
    cancel_jobs >/dev/null 2>&1 || true
    for pid_file in "$D"/run/*.pid; do
        id=$(cat "$pid_file" 2>/dev/null) || continue
        if tr '\0' ' ' <"/proc/$id/cmdline" 2>/dev/null | grep -qF -- "$D"; then
            ids+=("$id")
            kill "$id" 2>/dev/null || true
        fi
    done
    for id in "${ids[@]}"; do
        for _ in $(seq 100); do
            kill -0 "$id" 2>/dev/null || break
            sleep 0.1
        done
        kill -9 "$id" 2>/dev/null || true
    done
    rm -f "$D"/run/*.pid
}

# Jobs go before the daemons, which end those that do not listen: ranks that were left behind share
# memory by the number of their job, with those of the next private Slurm.
cancel_jobs() (
    # shellcheck source=/dev/null
    source "$D/env.sh"
    timeout 10 scancel --user="$(id -un)" --state=PENDING
    timeout 10 scancel --user="$(id -un)"
    for _ in $(seq 100); do
        [[ -n $(timeout 5 squeue --noheader) ]] || break
        sleep 0.1
    done
)

free_ports() { # how many
    python3 - "$1" <<'PY'
import socket, sys
held = [socket.create_server(("127.0.0.1", 0)) for _ in range(int(sys.argv[1]))]
print(*(each.getsockname()[1] for each in held))
PY
}

configure() {
    local host ctl node1 node2
    host=$(hostname -s)
    read -r ctl node1 node2 < <(free_ports 3)
    cat >"$D/slurm.conf" <<CONF
ClusterName=private
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$ctl
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
AuthType=auth/munge
AuthInfo=socket=$D/munge/socket
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$D/state
SlurmdSpoolDir=$D/spool/%n
TmpFS=$D/tmp/%n
SlurmctldPidFile=$D/run/slurmctld.pid
SlurmdPidFile=$D/run/%n.pid
SlurmctldLogFile=$D/log/slurmctld.log
SlurmdLogFile=$D/log/%n.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc=$D/completed.txt
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_interval=2
SwitchType=switch/none
FirstJobId=$((RANDOM * 30 + 1))
MpiDefault=none
ReturnToService=1
SlurmdTimeout=300
MinJobAge=3600
InactiveLimit=0
KillWait=2
MailProg=/bin/true
DefMemPerCPU=500
NodeName=floe1 NodeHostname=$host NodeAddr=127.0.0.1 Port=$node1 CPUs=${NODE_CPUS:-2} RealMemory=${NODE_MB:-8000}
NodeName=floe2 NodeHostname=$host NodeAddr=127.0.0.1 Port=$node2 CPUs=${NODE_CPUS:-2} RealMemory=${NODE_MB:-8000}
PartitionName=floes Nodes=floe1,floe2 Default=YES MaxTime=${PARTITION_MINUTES:-60} DefaultTime=10 State=UP
CONF
    # The jobstep plugin takes SLURM_* variables from the environment, SLURM_CONF with them, before
    # its own srun: commands of the same names put it back. A site's Slurm has its file in /etc.
    local command
    for command in srun sbatch squeue scancel scontrol sinfo; do
        printf '#!/bin/sh\nSLURM_CONF=%q exec /usr/bin/%s "$@"\n' "$D/slurm.conf" "$command" \
            >"$D/bin/$command"
        chmod 755 "$D/bin/$command"
    done
    cat >"$D/env.sh" <<ENV
case ":\$PATH:" in *":$D/bin:"*) ;; *) export PATH=$D/bin:\$PATH ;; esac
export SLURM_CONF=$D/slurm.conf
# Both nodes are this host: ranks talk over shared memory and loopback.
export OMPI_MCA_btl=self,vader,tcp OMPI_MCA_btl_tcp_if_include=lo OMPI_MCA_oob_tcp_if_include=lo
export PMIX_MCA_ptl_tcp_if_include=lo
ENV
}

start() {
    [[ $(id -u) == 0 ]] || fail "a private Slurm must be started as root."
    local name
    for name in slurmctld slurmd munged sbatch; do
        command -v "$name" >/dev/null || [[ -x /usr/sbin/$name ]] ||
            fail "there is no $name: 'make test-cluster' installs Debian's slurmctld, slurmd," \
                "slurm-client and munge."
    done
    stop
    rm -rf "$D"
    mkdir -p "$D"/{munge,state,spool/floe1,spool/floe2,tmp/floe1,tmp/floe2,log,run,bin}
    chmod 755 "$D" "$D/munge"
    (umask 077 && head -c 1024 /dev/urandom >"$D/munge/key")
    configure
    /usr/sbin/munged --key-file="$D/munge/key" --socket="$D/munge/socket" --num-threads=2 \
        --pid-file="$D/run/munged.pid" --log-file="$D/munge/log" --seed-file="$D/munge/seed" --force
    # shellcheck source=/dev/null
    source "$D/env.sh"
    /usr/sbin/slurmctld -f "$SLURM_CONF" -c
    for name in floe1 floe2; do /usr/sbin/slurmd -f "$SLURM_CONF" -c -N "$name"; done
    for _ in $(seq 300); do
        [[ $(sinfo -h -N -o %T 2>/dev/null | sort -u) == idle ]] && return 0
        sleep 0.1
    done
    fail "the private Slurm does not get its nodes idle: see $D/log."
}

"$action"
