# SPDX-License-Identifier: GPL-2.0-or-later
"""Run ``snakemake --lint`` and fail on any finding but one.

Tolerated is "Specify a conda environment or container": the environment of every rule is the one
that ``make setup`` builds from the lock, and LIGGGHTS comes from the distribution. Snakemake's
exit code does not tell findings apart and its JSON cannot be had from the command line, so the
findings are read from its text, where each starts a line with four blanks and a star.
"""

import subprocess
import sys

TOLERATED = "Specify a conda environment or container for each rule."


def intolerable(text: str) -> list[str]:
    """Return the lines that a reader must see of what ``snakemake --lint`` printed.

    Parameters
    ----------
    text : str
        The whole output: ``Lints for rule ...:`` with its findings below, each a title and an
        indented explanation.

    Returns
    -------
    list of str
        Each finding that is not tolerated, as ``rule ...: title``; empty where there is none.
    """
    place, found = "", []
    for line in text.splitlines():
        if line.startswith("Lints for "):
            place = line.removeprefix("Lints for ")
        elif line.startswith("    * "):
            title = line.removeprefix("    * ").removesuffix(":")
            if title != TOLERATED:
                found.append(f"{place} {title}")
    return found


def main(snakemake: str) -> int:
    """Lint the workflow of the current folder with a snakemake program; return the exit code."""
    run = subprocess.run([snakemake, "--lint"], capture_output=True, text=True)
    text = run.stdout + run.stderr
    lines = intolerable(text)
    if run.returncode and not lines and "Lints for " not in text:
        lines = [f"snakemake --lint did not get to its findings:\n{text}"]
    for line in lines:
        print(line, file=sys.stderr)
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
