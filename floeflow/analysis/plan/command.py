# SPDX-License-Identifier: GPL-2.0-or-later
"""What ``floeflow plan`` prints: settings for a wanted error or for a budget of time."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from floeflow.analysis.estimate.conditions import conditions
from floeflow.analysis.estimate.cost import COSTS, coefficients
from floeflow.analysis.estimate.expected import as_time
from floeflow.analysis.plan.pack import fitted_to_pack
from floeflow.analysis.plan.precision import PRECISION, error_model
from floeflow.analysis.plan.propose import Proposal, for_budget, for_error, parse_budget, proposals
from floeflow.analysis.plan.refit import refit
from floeflow.analysis.resolve import checked_scene
from floeflow.core.errors import FloeError, answer_quietly


def main(words: Sequence[str] | None = None) -> int:
    """Print a proposal, or fit the models anew.

    Parameters
    ----------
    words : sequence of str or None, optional
        Of the command line; None for those of the process.

    Returns
    -------
    int
        Exit code.
    """
    parser = argparse.ArgumentParser(
        prog="floeflow plan",
        description="Propose numerical settings for a scene, from a wanted error or run time.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("scene", type=Path, nargs="?", help="a scene file")
    aim = parser.add_mutually_exclusive_group(required=True)
    aim.add_argument("--error", type=float, help="largest relative error (0.05 is 5 %%)")
    aim.add_argument("--budget", help="longest wall time: 2h, 90m or 45s")
    aim.add_argument("--refit", action="store_true", help="fit cost and error model to studies")
    parser.add_argument("--ranks", type=int, default=1, help="number of MPI ranks")
    parser.add_argument(
        "--results", type=Path, default=Path("results"), help="folder of the studies, for --refit"
    )
    given = parser.parse_args(words)
    return answer_quietly(partial(_refit, given.results) if given.refit else partial(_plan, given))


def _refit(results: Path) -> str:
    names = refit(results, COSTS, PRECISION)
    return f"Fitted to {', '.join(names)}:\n  {COSTS}\n  {PRECISION}"


def _plan(given: argparse.Namespace) -> str:
    if given.scene is None:
        raise FloeError("name a scene file")
    if given.ranks < 1:
        raise FloeError(f"--ranks {given.ranks}: one rank at least")
    scene = checked_scene(given.scene)
    c = conditions(scene)
    fit = fitted_to_pack(scene, c, coefficients())
    found = proposals(scene, c, given.ranks, fit, error_model())
    own = found[0]
    if given.error is not None:
        if not given.error > 0:
            raise FloeError(f"--error {given.error}: give a share above 0, such as 0.05")
        best, least = for_error(found, given.error), min(found, key=lambda p: p.error)
        missing = f"No setting reaches an error of {given.error:g}; the least is"
    else:
        best = for_budget(found, parse_budget(given.budget))
        least = min(found, key=lambda p: p.seconds)
        missing = f"No setting stays below {given.budget}; the fastest is"
    lines = [f"Scene {scene.name} on {given.ranks} ranks, as it stands: {_say(own)}"]
    if best is None:
        lines += [missing, _say(least)]
    lines += ["Proposed:" if best else "with:", *_settings(best or least)]
    lines += [_say(best)] if best else []
    worst = sorted((best or least).parts.items(), key=lambda item: -item[1])
    lines += ["Error by setting: " + ", ".join(f"{k} {100 * e:.2g} %" for k, e in worst)]
    return "\n".join(lines)


def _settings(proposal: Proposal) -> list[str]:
    if not proposal.changes:
        return ["  the scene as it stands"]
    return [
        f"  {path}: {value if isinstance(value, str) else format(value, 'g')}"
        for path, value in proposal.changes.items()
    ]


def _say(proposal: Proposal) -> str:
    return f"about {as_time(proposal.seconds)}, error about {100 * proposal.error:.2g} %"
