# SPDX-License-Identifier: GPL-2.0-or-later
"""The set-up: each refusal is one sentence that leaves nothing behind, nothing is done twice.

The scripts run in a copy of the project with a PATH of links to the commands they may see and of
small programs that stand for the rest, so nothing is installed and no network is used.
"""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
BASE = (
    "bash cat cut diff dirname env find flock grep head id ln ls mkdir mktemp mv readlink rm sed "
    "sha256sum sort tail tr awk"
).split()
NEEDED = ("g++", "cmake", "mpirun", "mpicxx", "liggghts")
PYTHON = """#!/bin/sh
echo "python $*" >>"$LOG"
case "$*" in
*version_info*) echo {version} ;;
*ensurepip*) exit 0 ;;
*"-m venv"*) mkdir -p "$3/bin"; ln -sf "$0" "$3/bin/python" ;;
*base_executable*) readlink -f "$0" ;;
esac
"""
CMAKE = """#!/bin/sh
echo "cmake $*" >>"$LOG"
[ "$1" = -S ] || exit 0
mkdir -p "$4"
echo "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD/$2" >"$4/CMakeCache.txt"
"""
APT_CACHE = """#!/bin/sh
case "$2" in
{unknown}) echo "  Candidate: (none)" ;;
python3) echo "  Candidate: {python}" ;;
*) echo "  Candidate: 1.0-1" ;;
esac
"""


class Machine:
    """A copy of the project beside a PATH that holds only what a test puts there."""

    def __init__(self, folder: Path):
        self.project = folder / "project"
        self.bin = folder / "bin"
        self.log = folder / "log"
        self.bin.mkdir()
        shutil.copytree(ROOT / "setup", self.project / "setup")
        for name in ("pyproject.toml", "Makefile"):
            shutil.copy(ROOT / name, self.project)
        (self.project / "liggghts_models").mkdir()
        include = folder / "include"
        for header in ("doctest/doctest.h", "liggghts/lammps.h"):
            (include / header).parent.mkdir(parents=True)
            (include / header).touch()
        common = self.project / "setup/common.sh"
        text = common.read_text()
        assert "\ninclude=/usr/include\n" in text
        common.write_text(text.replace("include=/usr/include", f"include={include}"))
        for name in BASE:
            (self.bin / name).symlink_to(shutil.which(name))
        for name in NEEDED:
            self.program(name, "#!/bin/sh\n")
        self.program("cmake", CMAKE)
        self.program("python3", PYTHON.format(version="3.11"))
        self.program("id", "#!/bin/sh\necho 0\n")
        self.known()

    def program(self, name: str, text: str) -> None:
        path = self.bin / name
        path.unlink(missing_ok=True)
        path.write_text(text)
        path.chmod(0o755)

    def without(self, *names: str) -> "Machine":
        for name in names:
            (self.bin / name).unlink()
        return self

    def known(self, *, unknown: str = "nothing", python: str = "3.11.2-1") -> None:
        """Give the machine an apt that knows every package but the unknown ones."""
        self.program(
            "apt-get", '#!/bin/sh\necho "apt-get $*" >>"$LOG"\necho "ran apt-get $*" >&2\n'
        )
        self.program("apt-cache", APT_CACHE.format(unknown=unknown, python=python))

    def install(self, **variables: str) -> subprocess.CompletedProcess:
        self.log.write_text("")
        return subprocess.run(
            [self.bin / "bash", "setup/install.sh"],
            cwd=self.project,
            env={"PATH": str(self.bin), "LOG": str(self.log), "HOME": str(self.project)}
            | variables,
            capture_output=True,
            text=True,
        )

    def calls(self) -> list[str]:
        """What was called that changes something."""
        looks = re.compile(r"python .*(version_info|ensurepip|base_executable)")
        return [line for line in self.log.read_text().splitlines() if not looks.match(line)]

    def refuses(self, *words: str, **variables: str) -> str:
        """Check that the set-up ends in one sentence with these words and changes nothing."""
        run = self.install(**variables)
        assert run.returncode == 1, run.stderr
        lines = run.stderr.splitlines()
        assert len(lines) == 1 and lines[0].startswith("FloeFlow: "), run.stderr
        assert lines[0].endswith(".") or "ask an administrator" in lines[0]
        for word in words:
            assert word in lines[0]
        assert self.calls() == []
        assert not (self.project / ".venv").exists()
        assert not (self.project / "build/liggghts_models").exists()
        return lines[0]


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def test_no_apt_names_what_is_missing(machine: Machine) -> None:
    machine.without("apt-get", "cmake", "liggghts")
    machine.refuses("no apt-get", "cmake liggghts", "LIGGGHTS_ROOT=")


def test_no_root_and_no_sudo(machine: Machine) -> None:
    machine.without("g++").program("id", "#!/bin/sh\necho 1000\n")
    machine.refuses("root or sudo", "apt-get install g++")


def test_apt_forbidden(machine: Machine) -> None:
    machine.without("mpirun", "mpicxx")
    machine.refuses("NO_APT=1", "openmpi-bin libopenmpi-dev", NO_APT="1")


@pytest.mark.parametrize(("version", "word"), [("3.10", "older than 3.11"), ("3.14", "newer")])
def test_wrong_python(machine: Machine, version: str, word: str) -> None:
    machine.program("python3", PYTHON.format(version=version))
    machine.refuses(f"Python {version}", word, "PYTHON=")


def test_other_python_is_selected_and_checked(machine: Machine) -> None:
    machine.program("python3", PYTHON.format(version="3.9"))
    machine.program("other", PYTHON.format(version="3.10"))
    machine.refuses("Python 3.10", "older", PYTHON=str(machine.bin / "other"))
    machine.refuses("PYTHON=/nowhere", PYTHON="/nowhere")
    machine.program("other", PYTHON.format(version="3.12"))
    assert machine.install(PYTHON=str(machine.bin / "other")).returncode == 0
    assert "python 3.12" in (machine.project / ".venv/floeflow-stamp").read_text()


def test_python_of_the_distribution_is_too_old(machine: Machine) -> None:
    machine.without("python3").known(python="3.9.2-3")
    run = machine.install()
    assert run.returncode == 1
    assert "Python 3.9 (the distribution's python3) is older" in run.stderr.splitlines()[-1]
    assert not any("install" in call for call in machine.calls())


def test_no_liggghts_in_the_distribution(machine: Machine) -> None:
    machine.without("liggghts").known(unknown="*liggghts*")
    run = machine.install()
    assert run.returncode == 1
    last = run.stderr.splitlines()[-1]
    assert "LIGGGHTS is not in this distribution" in last and "LIGGGHTS_ROOT=" in last
    assert machine.calls() == ["apt-get -qq update"]  # looked again, installed nothing


def test_wrong_liggghts_root(machine: Machine) -> None:
    machine.refuses("LIGGGHTS_ROOT=/nowhere", "libliggghts.so", LIGGGHTS_ROOT="/nowhere")


def test_own_liggghts_needs_no_package(machine: Machine, tmp_path: Path) -> None:
    own = tmp_path / "own liggghts"
    for name in ("src/granular_pair_style.h", "build/libliggghts.so"):
        (own / name).parent.mkdir(parents=True, exist_ok=True)
        (own / name).touch()
    machine.without("liggghts").known(unknown="*liggghts*")
    run = machine.install(LIGGGHTS_ROOT=str(own))
    assert run.returncode == 0, run.stderr
    assert any(
        f"-DLIGGGHTS_ROOT={own}" in call and f"-DLIGGGHTS_INCLUDE={own}/src" in call
        for call in machine.calls()
    )
    assert not any(call.startswith("apt-get") for call in machine.calls())


def test_packages_are_named_before_sudo_and_a_failure_leaves_nothing(machine: Machine) -> None:
    machine.without("g++", "cmake").program("id", "#!/bin/sh\necho 1000\n")
    machine.program("sudo", '#!/bin/sh\necho "ran sudo $*" >&2\nexit 1\n')
    run = machine.install()
    lines = run.stderr.splitlines()
    assert run.returncode == 1
    assert lines[0].endswith("'sudo apt-get install': g++ cmake")
    assert lines[1].startswith("ran sudo env DEBIAN_FRONTEND=noninteractive apt-get -qq install")
    assert lines[1].endswith("--no-install-recommends g++ cmake")
    assert "failed" in lines[-1]
    assert not (machine.project / ".venv").exists()


def test_what_apt_did_not_bring_is_named(machine: Machine) -> None:
    machine.without("mpirun")
    run = machine.install()
    assert run.returncode == 1
    assert "still missing" in run.stderr and run.stderr.rstrip().endswith("openmpi-bin.")


def test_nothing_is_done_twice(machine: Machine) -> None:
    first = machine.install()
    assert first.returncode == 0, first.stderr
    calls = machine.calls()
    assert any("-m venv" in call for call in calls)
    assert any("--require-hashes" in call and "--only-binary :all:" in call for call in calls)
    assert any("--editable" in call for call in calls)
    assert any(call.startswith("cmake -S") for call in calls)

    build = ["cmake --build build/liggghts_models --parallel 2"]
    again = machine.install()
    assert again.returncode == 0 and again.stderr == ""
    assert machine.calls() == build

    with (machine.project / "setup/requirements.lock").open("a") as lock:
        lock.write("# changed\n")
    machine.install()
    assert any("--require-hashes" in call for call in machine.calls())
    assert not any(call.startswith("cmake -S") for call in machine.calls())

    with (machine.project / "pyproject.toml").open("a") as project:
        project.write("# changed\n")
    machine.install()
    assert [call for call in machine.calls() if "pip install" in call] == [
        "python -m pip install --quiet --disable-pip-version-check --no-deps "
        "--no-build-isolation --editable ."
    ]


def test_a_changed_project_is_installed_anew_without_what_the_old_left(machine: Machine) -> None:
    assert machine.install().returncode == 0
    project, site = machine.project, machine.project / ".venv/lib/python3.11/site-packages"
    stale = [
        project / "floeflow.egg-info/SOURCES.txt",
        site / "__editable___floeflow_0_1_0_finder.py",
        site / "__editable__.floeflow-0.1.0.pth",
    ]
    for path in (*stale, site / "__editable__.other-1.pth"):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    assert machine.install().returncode == 0
    assert not [call for call in machine.calls() if "--editable" in call]
    assert all(path.exists() for path in stale)
    with (project / "pyproject.toml").open("a") as file:
        file.write("\n# changed\n")
    assert machine.install().returncode == 0
    assert len([call for call in machine.calls() if "--editable ." in call]) == 1
    assert not [path for path in stale if path.exists()]
    assert (site / "__editable__.other-1.pth").exists()


def test_what_python_compiled_of_moved_sources_is_swept(machine: Machine) -> None:
    library = machine.project / "floeflow"
    for name in ("there/__pycache__/a.pyc", "gone/deep/__pycache__/b.pyc", "there/a.py"):
        (library / name).parent.mkdir(parents=True, exist_ok=True)
        (library / name).touch()
    assert machine.install().returncode == 0
    assert (library / "there/__pycache__/a.pyc").exists()
    assert not (library / "gone").exists()


def test_a_moved_project_is_set_up_anew(machine: Machine, tmp_path: Path) -> None:
    assert machine.install().returncode == 0
    machine.project = machine.project.rename(tmp_path / "moved")
    assert machine.install().returncode == 0
    assert any("-m venv" in call for call in machine.calls())
    assert any(call.startswith("cmake -S") for call in machine.calls())


def test_failing_pip_keeps_the_environment_there_was(machine: Machine) -> None:
    assert machine.install().returncode == 0
    kept = machine.project / ".venv/kept"
    kept.touch()
    failing = PYTHON.format(version="3.11").replace("esac", "*--require-hashes*) exit 1 ;;\nesac")
    machine.program("python3", failing)
    with (machine.project / "setup/requirements.lock").open("a") as lock:
        lock.write("# changed\n")
    run = machine.install()
    assert run.returncode == 1
    assert "pip" in run.stderr.splitlines()[-1]
    assert kept.exists() and not (machine.project / ".venv.old").exists()


def test_an_environment_half_made_is_not_kept(machine: Machine) -> None:
    half = machine.project / ".venv/bin/half"
    half.parent.mkdir(parents=True)
    half.touch()
    failing = PYTHON.format(version="3.11").replace("esac", "*--require-hashes*) exit 1 ;;\nesac")
    machine.program("python3", failing)
    assert machine.install().returncode == 1
    assert not (machine.project / ".venv").exists()
    machine.program("python3", PYTHON.format(version="3.11"))
    assert machine.install().returncode == 0
    assert not half.exists()


def test_doctor_says_what_is_missing_before_the_set_up(machine: Machine) -> None:
    machine.without("cmake", "python3")
    run = subprocess.run(
        [machine.bin / "bash", "setup/doctor.sh"],
        cwd=machine.project,
        env={"PATH": str(machine.bin), "LOG": str(machine.log)},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 1
    missing = dict(re.findall(r"MISSING  (.{16}) (.*)", run.stdout))
    missing = {name.strip(): how for name, how in missing.items()}
    assert missing["cmake"] == "apt package cmake"
    assert "PYTHON=" in missing["python3"]
    assert "make setup" in missing[".venv"] and "make setup" in missing["plugin"]
    assert "probe" in missing
    assert "mpirun" not in missing
