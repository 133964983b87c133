#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# Says running, success or failed of a Slurm job, as the plugin cluster-generic asks. The controller
# knows jobs until minutes after their end (MinJobAge), accounting, where there is any, for good.
state=$(scontrol show job --oneliner "$1" 2>&1) || {
    case $state in
    *"Invalid job id"*) state=JobState=$(sacct -X -n -P -o State -j "$1" 2>/dev/null | head -n 1) ;;
    *) state=JobState=UNREACHABLE ;; # asked again later
    esac
}
state=${state#*JobState=}
case ${state%%[ +]*} in
COMPLETED) echo success ;;
PENDING | CONFIGURING | RUNNING | COMPLETING | SUSPENDED | STOPPED | RESIZING | SIGNALING | \
    STAGE_OUT | REQUEUED | REQUEUE_HOLD | REQUEUE_FED | UNREACHABLE) echo running ;;
*) echo failed ;;
esac
