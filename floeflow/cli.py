# SPDX-License-Identifier: GPL-2.0-or-later
"""The command ``floeflow``: look at a scene, plan it, run it, or run a column alone."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from floeflow.analysis import documents, input_check
from floeflow.analysis.estimate.command import tell
from floeflow.analysis.plan import command as plan_command
from floeflow.analysis.reading_process import files_behind
from floeflow.analysis.resolve import checked_scene
from floeflow.analysis.single_column import run as column_command
from floeflow.core.atomic_write import spare_inputs
from floeflow.core.errors import FloeError, answer, answer_quietly
from floeflow.report.run_so_far import report_so_far
from floeflow.scene.docs import PROJECT

app = typer.Typer(
    name="floeflow",
    help="FloeFlow, a discrete element model of sea ice.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
SceneFile = Annotated[Path, typer.Argument(help="Path of the scene file (YAML).")]
# Commands with many options of their own parse them themselves, help included.
OWN_OPTIONS = {"allow_extra_args": True, "ignore_unknown_options": True, "help_option_names": []}


def _end(command: Callable[[], object]) -> None:
    raise typer.Exit(answer(command))


@app.command()
def run(
    scene: SceneFile,
    cores: Annotated[
        int, typer.Option(help="Number of cores to use; 0: those of the profile.")
    ] = 0,
) -> None:
    """Run a scene on this machine with Snakemake and write its report."""
    if not (PROJECT / "Snakefile").is_file():
        _end(_no_workflow)
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(PROJECT / "Snakefile")]
    command += ["--profile", str(PROJECT / "workflows/profiles/local")]
    command += ["--cores", str(cores)] if cores else []
    code = subprocess.run([*command, "--config", f"scene={scene}"], check=False).returncode
    raise typer.Exit(code)


def _no_workflow() -> str:
    raise FloeError(
        "'floeflow run' needs a checkout of the project: the workflow is no part of the wheel"
    )


@app.command()
def check(
    scene: SceneFile,
    plot: Annotated[
        Path | None, typer.Option(help="Also draw maps of all inputs to this PNG file.")
    ] = None,
) -> None:
    """Validate a scene and its input files; list its effects and the source of each quantity."""
    _end(partial(_check, scene, plot))


def _check(path: Path, plot: Path | None) -> str:
    scene = checked_scene(path)
    if plot is not None:
        spare_inputs("--plot", plot, [path, *(Path(name) for name, _, _ in files_behind(scene))])
    said = [f"{path}: scene '{scene.name}' with {', '.join(scene.effects)}"]
    said.append(input_check.say(input_check.find_inputs(scene)))
    if plot is not None:
        input_check.draw(scene, plot)
        said.append(f"Maps: {plot}")
    return "\n".join(said)


@app.command()
def effects(
    scene: SceneFile,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")] = False,
) -> None:
    """Estimate what each effect changes (%) and costs (% of run time); recommend effects."""
    raise typer.Exit(answer_quietly(partial(tell, scene, as_json)))


@app.command(context_settings=OWN_OPTIONS)
def plan(context: typer.Context) -> None:
    """Propose numerical settings for a wanted error or run time (options: plan --help)."""
    raise typer.Exit(plan_command.main(context.args))


@app.command(context_settings=OWN_OPTIONS)
def column(context: typer.Context) -> None:
    """Run a single column of sea ice without elements (options: column --help)."""
    raise typer.Exit(column_command.main(context.args))


@app.command()
def report(
    folder: Annotated[
        Path, typer.Argument(help="Folder results/<scene> of a run, finished or not.")
    ],
) -> None:
    """Write a report of the finished windows of a run, also while it is running."""
    _end(partial(report_so_far, folder))


@app.command()
def compare(
    folder: Annotated[Path, typer.Argument(help="results/<scene> of a run that has ended.")],
    buoys: Annotated[
        list[Path] | None, typer.Option(help="CSV of tracks: id, time, lon, lat; IABP; MOSAiC.")
    ] = None,
    concentration: Annotated[
        Path | None, typer.Option(help="Gridded ice concentration with times.")
    ] = None,
    variable: Annotated[str, typer.Option(help="Its variable, where no standard name tells.")] = "",
    crs: Annotated[str, typer.Option(help="Its projection, where the file does not tell.")] = "",
    thickness: Annotated[
        list[Path] | None, typer.Option(help="CSV of thickness: time, lon, lat, thickness (m).")
    ] = None,
    beside: Annotated[
        list[Path] | None, typer.Option("--with", help="results/<scene> of another run.")
    ] = None,
) -> None:
    """Compare a run with buoys, concentration and thickness, and with other runs."""
    # Its figures take a second to import.
    from floeflow.analysis.observations.compare import Observed
    from floeflow.analysis.observations.compare import compare as run_compare

    observed = Observed(buoys or (), thickness or (), concentration, variable, crs)
    _end(partial(run_compare, folder, observed, beside or ()))


@app.command()
def docs(
    write: Annotated[
        bool, typer.Option(help="Write the documents; without it, only compare.")
    ] = False,
) -> None:
    """Compare the generated documents with the code, or write them."""
    _end(documents.write_documents if write else documents.check_documents)


@app.command()
def doctor() -> None:
    """List what is installed and what is missing, and test the plugin."""
    script = PROJECT / "setup/doctor.sh"
    if not script.is_file():
        _end(_no_doctor)
    raise typer.Exit(subprocess.run([str(script)], check=False).returncode)


def _no_doctor() -> str:
    raise FloeError("'floeflow doctor' needs a checkout of the project")


if __name__ == "__main__":
    app()
