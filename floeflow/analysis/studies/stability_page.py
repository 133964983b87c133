# SPDX-License-Identifier: GPL-2.0-or-later
"""Page of the hard cases: what each one showed, in one table and two figures."""

from typing import Any

from floeflow.report.study_page import Table, cell

LEAD = (
    "Each hard case must stay finite, lose nothing, make no energy and keep its bounds. Why each "
    "is hard and what must hold in it is told in docs/stability.md."
)
Shown = dict[str, Any]
ENDS = ("passed", "skipped", "expected failure", "failed")


def case_table(shown: list[Shown]) -> Table:
    """Row for each test: case, what it shows, outcome, figures.

    Parameters
    ----------
    shown : list of Shown
        Records of tests.
    """
    rows = []
    for entry in shown:
        figures = {name: v for name, v in entry["figures"].items() if isinstance(v, int | float)}
        said = ", ".join(f"{name.replace('_', ' ')} {cell(v)}" for name, v in figures.items())
        what = entry["what"].splitlines()[0].rstrip(".")
        place = entry["test"].partition("[")[2].rstrip("]")
        rows.append(
            (entry["module"], f"{what} ({place})" if place else what, entry["outcome"], said)
        )
    return Table("Hard cases", ("case", "what", "outcome", "figures"), rows)


def summary(shown: list[Shown]) -> Table:
    """Row for each case: its tests, how they ended, the largest part of the energy missed.

    Parameters
    ----------
    shown : list of Shown
        Records of tests.
    """
    rows = []
    for module in sorted({entry["module"] for entry in shown}):
        own = [entry for entry in shown if entry["module"] == module]
        ended = [sum(entry["outcome"] == word for entry in own) for word in ENDS]
        missed = [abs(e["figures"]["residual"]) for e in own if "residual" in e["figures"]]
        rows.append([module, len(own), *ended, 100 * max(missed) if missed else "–"])
    return Table("Cases", ("case", "tests", *ENDS, "largest energy residual (%)"), rows)


def sentences(shown: list[Shown]) -> list[str]:
    """How many there are and how they ended.

    Parameters
    ----------
    shown : list of Shown
        Records of tests.
    """
    modules = {entry["module"] for entry in shown}
    ended: dict[str, int] = {}
    for entry in shown:
        ended[entry["outcome"]] = ended.get(entry["outcome"], 0) + 1
    said = ", ".join(f"{count} {name}" for name, count in sorted(ended.items()))
    out = [f"{len(modules)} cases with {len(shown)} tests: {said}."]
    for name, packs in (
        ("default_over_largest", "bonded packs"),
        ("unbonded_default_over_largest", "packs that contacts alone hold"),
    ):
        shares = [round(100.0 * e["figures"][name]) for e in shown if name in e["figures"]]
        if shares:
            least, most = min(shares), max(shares)
            said = f"{most}" if least == most else f"{least} to {most}"
            out.append(f"The default step is {said} % of the largest stable one in {packs}.")
    return out


def residuals(shown: list[Shown]) -> dict[str, float]:
    """Energy not accounted for, by case and test.

    Parameters
    ----------
    shown : list of Shown
        Records of tests.

    Returns
    -------
    dict
        Residual of each test with an energy budget (1).
    """
    return {
        f"{entry['module']}: {entry['test'].removeprefix('test_').replace('_', ' ')}": value
        for entry in shown
        if (value := entry["figures"].get("residual")) is not None
    }
