# SPDX-License-Identifier: GPL-2.0-or-later
"""What a user who asks for ranks should know: Snakemake cuts them to its cores, unsaid."""

from __future__ import annotations

import os
import sys
from typing import Any

from floeflow.core.errors import FloeError

RULE = "windows"


def asked_ranks(settings: Any) -> Any:
    """What the command line asks for as ranks: a number, another value, or None.

    Parameters
    ----------
    settings : object
        Of Snakemake's command line.

    Returns
    -------
    object
        As Snakemake holds it.
    """
    asked = getattr(settings, "overwrite_threads", {}).get(RULE)
    return getattr(asked, "raw", asked)


def check_ranks(settings: Any) -> None:
    """Say on standard error what becomes of the ranks that the command line asks for.

    Parameters
    ----------
    settings : snakemake.settings.types.ResourceSettings
        Of the running workflow.

    Raises
    ------
    FloeError
        Where that are none.
    """
    asked = asked_ranks(settings)
    cores = getattr(settings, "cores", None)
    if asked == 0:
        raise FloeError(f"--set-threads {RULE}=0: a window needs at least one rank")
    if isinstance(asked, int) and isinstance(cores, int):
        processors = len(os.sched_getaffinity(0))
        if sentence := ranks_sentence(asked, cores, processors):
            print(f"floeflow: warning: {sentence}", file=sys.stderr, flush=True)


def ranks_sentence(asked: int, cores: int, processors: int) -> str:
    """What is to be said of a number of ranks; empty where that is nothing.

    Parameters
    ----------
    asked, cores, processors : int
        Ranks of a window, cores that Snakemake may use, processors that there are.

    Returns
    -------
    str
        Without a full stop.
    """
    if asked > cores:
        return (
            f"{asked} ranks are asked for (--set-threads {RULE}={asked}), and --cores {cores} "
            f"allows {cores}: windows run on {cores}, with the bits of {cores}"
        )
    if asked > processors:
        return (
            f"{asked} ranks share {processors} processors: windows are slower than on "
            f"{processors}, and have the bits of {asked}"
        )
    return ""
