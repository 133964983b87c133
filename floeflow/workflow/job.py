# SPDX-License-Identifier: GPL-2.0-or-later
"""How a rule's module becomes a program: its log, its lock, its way to fail.

Every stage holds the scene's job lock while it runs. A job that outlives a killed workflow is
thereby seen by the next one, which refuses to write beside it (``floeflow.core.lock``).
"""

from __future__ import annotations

import logging
import os
import resource
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from floeflow.core.errors import FloeError
from floeflow.core.lock import hold_job
from floeflow.core.records import CPU_LINE
from floeflow.scene import Scene, load_scene


class Snakemake(Protocol):
    """What a module uses of the object that Snakemake hands to a script."""

    input: Any
    output: Any
    params: Any
    log: Any
    config: Any
    wildcards: Any
    threads: int


def run_script(main: Callable[[Snakemake], None], snakemake: Snakemake) -> None:
    """Run a rule's script: logging to its log, a fault as one sentence, exit code 1."""
    log = Path(str(snakemake.log[0]))
    log.parent.mkdir(parents=True, exist_ok=True)
    form = "%(asctime)s %(name)s %(levelname)s %(message)s"
    logging.basicConfig(filename=log, filemode="w", level=logging.INFO, format=form)
    try:
        with hold_job(scene_folder(snakemake)):
            main(snakemake)
        logging.info("%s%.3f s", CPU_LINE, cpu_seconds())
    except FloeError as error:
        logging.error("%s", error)
        print(f"floeflow: {error}", file=sys.stderr, flush=True)
        # Leave without unwinding through Snakemake's preamble, which would print a traceback.
        logging.shutdown()
        os._exit(1)
    except Exception:
        logging.exception("unexpected fault")
        raise


def cpu_seconds() -> float:
    """CPU seconds of this process and of the children that it waited for."""
    own, children = (
        resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


def scene_of(snakemake: Snakemake) -> Scene:
    """Scene of the running stage."""
    return load_scene(snakemake.config["scene"])


def scene_folder(snakemake: Snakemake) -> Path:
    """``results/<scene>`` of the running stage; the folder of its output where it has no scene."""
    name = getattr(snakemake.wildcards, "scene", None)
    return Path("results") / str(name) if name else Path(str(snakemake.output[0])).parent
