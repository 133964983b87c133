# SPDX-License-Identifier: GPL-2.0-or-later
"""The engine on one rank: what the plugin does to elements, against theory and itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from floeflow.core.errors import FloeError
from floeflow.dynamics.engine.engine import Engine, EngineError, Forcing
from support.full_ice import full_params
from support.rafts import angular_momentum, bonded, discs, lattice, uniform

SELF = MPI.COMM_SELF
EXTERNAL = {"wind": True, "ocean_drag": True, "coriolis": True, "tilt": True}


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return tmp_path / "liggghts.log"


def same(a: dict[str, np.ndarray], b: dict[str, np.ndarray]) -> None:
    assert a.keys() == b.keys()
    for name in a:
        np.testing.assert_array_equal(a[name], b[name], err_msg=name)


def test_a_free_element_moves_straight(log: Path) -> None:
    one = discs(100.0, 200.0)
    one["u"][:], one["v"][:], one["omega"][:] = 0.5, -0.25, 1e-3
    with Engine(SELF, full_params(time_step=2.0), log) as engine:
        engine.load(one)
        engine.run(1024)
        out = engine.elements()
    assert out["x"][0] == 100.0 + 1024 and out["y"][0] == 200.0 - 512
    assert out["u"][0] == 0.5 and out["v"][0] == -0.25 and out["omega"][0] == 1e-3
    assert out["theta"][0] == pytest.approx(2.048, rel=1e-12)


@pytest.mark.parametrize("thickness", [10.0, 1e-2, 1e-6])
def test_terminal_drift(log: Path, thickness: float) -> None:
    params = full_params(time_step=60.0, wind=True, ocean_drag=True)
    terminal = 30.0 * math.sqrt(params.wind_stress_factor / params.ocean_stress_factor)
    with Engine(SELF, params, log) as engine:
        engine.load(discs(0.0, 0.0, thickness=thickness))
        engine.set_forcing(uniform(wind=(30.0, 0.0)))
        fastest = 0.0
        for _ in range(200):
            engine.run(50)
            fastest = max(fastest, engine.elements()["u"][0])
        final = engine.elements()
    assert final["u"][0] == pytest.approx(terminal, rel=1e-8)
    assert fastest <= 1.01 * terminal
    assert abs(final["v"][0]) < 1e-12


@pytest.mark.parametrize("hemisphere", [1.0, -1.0])
def test_a_turned_drag_deflects_to_the_right_in_the_north_and_to_the_left_in_the_south(
    log: Path, hemisphere: float
) -> None:
    """Free drift of thin ice: the water's drag balances the wind, turned by the angle alone."""
    angle = math.radians(21.0)
    params = full_params(time_step=60.0, wind=True, ocean_drag=True, turning_angle=angle)
    with Engine(SELF, params, log) as engine:
        engine.load(discs(0.0, 0.0, thickness=0.1))
        engine.set_forcing(uniform(wind=(10.0, 0.0), coriolis=hemisphere * 1.4e-4))
        engine.run(5000)
        final = engine.elements()
    off = math.degrees(math.atan2(final["v"][0], final["u"][0]))
    assert off == pytest.approx(-21.0 * hemisphere, abs=1e-6)


def test_inertial_circle(log: Path) -> None:
    f = 1.4e-4
    one = discs(5e4, -3e4)
    one["u"][:] = 0.3
    params = full_params(time_step=2 * math.pi / f / 20000, coriolis=True)
    with Engine(SELF, params, log) as engine:
        engine.load(one)
        engine.set_forcing(uniform(coriolis=f))
        engine.run(10000)
        half = engine.elements()
        engine.run(10000)
        full = engine.elements()
    assert half["y"][0] == pytest.approx(-3e4 - 2 * 0.3 / f, abs=1e-3 * 0.3 / f)
    assert math.hypot(full["x"][0] - 5e4, full["y"][0] + 3e4) < 1e-6 * 0.3 / f
    assert math.hypot(full["u"][0], full["v"][0]) == pytest.approx(0.3, rel=1e-12)


def test_forcing_is_taken_in_the_middle_of_the_step_and_at_the_scene_time(log: Path) -> None:
    # Wind grows linearly with time, no drag: the impulse over a step is exact.
    time = np.array([1000.0, 3000.0])
    wind = np.array([0.0, 20.0])[:, None, None] * np.ones((2, 2, 2))
    fields = {"wind_u": wind, "wind_v": 0 * wind}
    edge = np.array([-1e6, 1e6])
    params = full_params(time_step=100.0, wind=True)
    one = discs(0.0, 0.0)
    with Engine(SELF, params, log) as engine:
        engine.load(one, time=1400.0)
        engine.set_forcing(Forcing(time, edge, edge, fields))
        engine.run(1)
        stress = params.wind_stress_factor * 4.5**2
        expected = 100.0 * stress * one["ice_area"] / one["mass"]
        assert engine.elements()["u"][0] == pytest.approx(expected[0], rel=1e-12)
        with pytest.raises(FloeError, match="covers 1000 s to 3000 s"):
            engine.run(16)


def free_raft() -> dict[str, np.ndarray]:
    raft = lattice(6, 5)
    random = np.random.default_rng(3)
    for name, size in (("u", 0.01), ("v", 0.01), ("omega", 1e-6)):
        raft[name] = size * random.normal(size=len(raft["id"]))
    return raft


def test_momentum_of_a_cracking_free_raft(log: Path) -> None:
    raft = free_raft()
    raft["u"] *= 20
    raft["u"] -= 2e-5 * raft["x"]  # squeezed and torn
    params = full_params(time_step=0.2, bonds=True)
    with Engine(SELF, params, log) as engine:
        engine.load(raft, bonded(raft))
        engine.run(1000)
        out, sums = engine.elements(), engine.diagnostics()
    assert 0 < sums["bonds"] < len(bonded(raft)["id_lo"])
    assert sums["contacts"] > 0
    for name in ("u", "v"):
        before, after = (m["mass"] @ m[name] for m in (raft, out))
        assert abs(after - before) < 1e-12 * (out["mass"] @ np.abs(out[name]))
    (before, _), (after, parts) = angular_momentum(raft), angular_momentum(out)
    assert abs(after - before) < 1e-10 * parts


def test_energy_of_an_undamped_raft(log: Path) -> None:
    raft = free_raft()
    params = full_params(
        time_step=0.1, bonds=True, bond_damping=0.0, compressive_strength=1e9, friction=False
    )
    with Engine(SELF, params, log) as engine:
        engine.load(raft, bonded(raft))
        energies = []
        for _ in range(40):
            d = engine.diagnostics()
            energies.append(d["kinetic_now"] + d["rotational_now"] + d["elastic_bond"])
            engine.run(100)
        assert engine.diagnostics()["elastic_bond"] > 0.1 * energies[0]
    assert np.mean(energies[20:]) == pytest.approx(np.mean(energies[:20]), rel=1e-4)


def test_budgets_close_with_all_terms_and_a_coast(log: Path) -> None:
    raft = free_raft()
    raft["type"][:6] = 2  # the lowest row is coast
    raft["u"][:6] = raft["v"][:6] = raft["omega"][:6] = 0.0
    params = full_params(time_step=0.5, bonds=True, turning_angle=0.3, **EXTERNAL)
    table = bonded(raft)
    fixed = (table["id_lo"] <= 6) & (table["id_hi"] <= 6)
    table = {name: values[~fixed] for name, values in table.items()}
    with Engine(SELF, params, log) as engine:
        engine.load(raft, table)
        engine.set_forcing(uniform((4.0, -12.0), (0.1, 0.2), 1.4e-4))
        first = engine.diagnostics()
        engine.run(2000)
        last, out = engine.diagnostics(), engine.elements()
    for axis in "xy":
        terms = [last[f"impulse_{k}_{axis}"] for k in ("wind", "ocean", "coriolis", "tilt")]
        terms.append(-last[f"impulse_fixed_{axis}"])
        change = last[f"momentum_{axis}"] - first[f"momentum_{axis}"]
        assert abs(change - sum(terms)) < 1e-11 * sum(abs(t) for t in terms)
        assert abs(last[f"impulse_fixed_{axis}"]) > 0
    works = [last[f"work_{k}"] for k in ("wind", "ocean", "coriolis", "tilt", "contact")]
    change = last["kinetic"] - first["kinetic"]
    assert abs(change - sum(works)) < 1e-11 * sum(abs(w) for w in works)
    for name in ("x", "y", "u", "v", "omega"):
        np.testing.assert_array_equal(out[name][:6], raft[name][:6])


def collision_residual(log: Path, step: float) -> float:
    pair = discs([0.0, 2001.0], [0.0, 300.0])
    pair["u"][:], pair["v"][:] = [0.5, -0.5], [0.1, 0.0]
    with Engine(SELF, full_params(time_step=step, friction=True), log) as engine:
        engine.load(pair)
        first = engine.diagnostics()
        engine.run(round(60.0 / step))
        last = engine.diagnostics()
    energy = [d["kinetic"] + d["rotational"] + d["elastic_contact"] for d in (first, last)]
    lost = sum(last[f"dissipation_{k}"] for k in ("contact", "friction"))
    assert lost > 0.05 * energy[0]
    return abs(energy[0] - energy[1] - lost) / energy[0]


def test_energy_lost_in_a_collision_is_what_damping_and_friction_took(log: Path) -> None:
    residuals = [collision_residual(log, 0.4 / 2**k) for k in range(3)]
    assert residuals[0] < 0.02
    assert residuals[1] < 0.6 * residuals[0] and residuals[2] < 0.6 * residuals[1]


def pulled_apart(log: Path, thickness: float, velocity: tuple[float, float]) -> tuple[int, float]:
    """Steps until the bond of a fixed and a driven element breaks, and the displacement then."""
    pair = discs([0.0, 2000.0], [0.0, 0.0], thickness=thickness)
    pair["type"][0] = 2
    pair["mass"][1] = 1e27  # drives: the bond does not slow it down
    pair["u"][1], pair["v"][1] = velocity
    params = full_params(time_step=0.01, bonds=True)
    with Engine(SELF, params, log) as engine:
        engine.load(pair, bonded(pair))
        for step in range(1, 10000):
            engine.run(1)
            if len(engine.bonds()["id_lo"]) == 0:
                out = engine.elements()
                return step, math.hypot(out["x"][1] - 2000.0, out["y"][1])
    raise AssertionError("the bond does not break")


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (0.6, -0.8), (-1.0, 0.0)])
def test_a_bond_breaks_at_the_closed_form_displacement(
    log: Path, direction: tuple[float, float]
) -> None:
    p = full_params(time_step=0.01)
    normal, shear = direction[0], abs(direction[1])
    if normal < 0:
        limit = 2000.0 * p.compressive_strength / p.young_modulus
    else:
        stiffness = p.young_modulus * normal + p.shear_modulus * shear / math.tan(p.friction_angle)
        limit = 2000.0 * p.tensile_share * p.compressive_strength / stiffness
    speed = 0.05 if normal >= 0 else 0.5  # ice bears far more in compression
    velocity = (speed * direction[0], speed * direction[1])
    results = [pulled_apart(log, h, velocity) for h in (0.2, 1.0, 3.0)]
    assert len({steps for steps, _ in results}) == 1
    assert limit <= results[0][1] <= limit + 1.001 * speed * 0.01


def test_a_bond_that_breaks_in_overlap_makes_no_new_force(log: Path) -> None:
    pair = discs([0.0, 2000.0], [0.0, 0.0])
    pair["type"][0] = 2
    pair["mass"][1] = 1e27
    pair["u"][1] = -1.0
    with Engine(SELF, full_params(time_step=0.1, bonds=True), log) as engine:
        engine.load(pair, bonded(pair))
        engine.run(30)
        state, contacts = engine.elements(), engine.contacts()
        assert len(engine.bonds()["id_lo"]) == 0 and len(contacts["id_lo"]) == 1
        # The break came at 2 m of overlap; what was pushed in since then makes force.
        assert contacts["rest_overlap"][0] == pytest.approx(2.1, abs=0.11)
        state["mass"][1], state["u"][1] = 1e9, 0.0
        overlap = 2000.0 - state["x"][1]
        contacts["rest_overlap"][0] = overlap
        engine.load(state, None, contacts)
        engine.run(1000)
        np.testing.assert_array_equal(engine.elements()["x"], state["x"])
        engine.load(state, None, None)
        engine.run(1000)
        assert engine.elements()["x"][1] > state["x"][1] + overlap


def chain() -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """A bent line of discs: two neighbours at most, so that sums do not depend on their order."""
    n = 14
    x = 1990.0 * np.arange(n)
    line = discs(x, 150.0 * np.sin(np.arange(n)))
    random = np.random.default_rng(5)
    line["u"], line["v"] = 0.15 * random.normal(size=(2, n))
    table = bonded(line)
    keep = table["id_lo"] % 4 != 0  # every fourth pair only touches
    return line, {name: values[keep] for name, values in table.items()}


def test_cut_and_continued_in_the_middle_of_fracture(log: Path) -> None:
    line, table = chain()
    params = full_params(time_step=0.2, bonds=True, **EXTERNAL)
    forcing = uniform((8.0, 3.0), (0.1, 0.0), 1.4e-4)
    with Engine(SELF, params, log) as engine:
        engine.load(line, table)
        engine.set_forcing(forcing)
        engine.run(150)
        cut = engine.elements(), engine.bonds(), engine.contacts()
        engine.run(700)
        whole = engine.elements(), engine.bonds(), engine.contacts()
    cracks = cut[1]["crack_a"] + cut[1]["crack_b"]
    assert ((cracks > 0) & (cracks < 1)).any() and len(cracks) < len(table["id_lo"])
    assert (cut[2]["slip"] != 0).any()
    assert len(whole[1]["id_lo"]) < len(cracks)  # fracture goes on
    with Engine(SELF, params, log) as engine:
        engine.load(*cut, time=150 * params.time_step)
        engine.set_forcing(forcing)
        for k, table_now in enumerate((engine.elements(), engine.bonds(), engine.contacts())):
            same(table_now, cut[k])
        engine.run(700)
        for k, table_now in enumerate((engine.elements(), engine.bonds(), engine.contacts())):
            same(table_now, whole[k])


def test_the_same_state_gives_the_same_bits_and_so_do_pieces_of_a_run(log: Path) -> None:
    raft = free_raft()
    raft["u"] *= 20
    results = []
    with Engine(SELF, full_params(time_step=0.2, bonds=True), log) as engine:
        for pieces in ((1500,), (1500,), (1, 700, 799)):
            engine.load(raft, bonded(raft))
            for steps in pieces:
                engine.run(steps)
            results.append((engine.elements(), engine.bonds(), engine.contacts()))
    for other in results[1:]:
        for a, b in zip(results[0], other, strict=True):
            same(a, b)


def test_liggghts_stays_silent(log: Path, capfd: pytest.CaptureFixture[str]) -> None:
    for _ in range(2):  # its warnings come with the second opening
        with Engine(SELF, full_params(time_step=1.0), log) as engine:
            engine.load(discs(0.0, 0.0))
            engine.run(3)
    captured = capfd.readouterr()
    assert captured.out == "" and captured.err == ""
    assert "LIGGGHTS" in log.read_text()


def test_an_unstable_step_names_the_element(log: Path) -> None:
    raft = lattice(4, 4)
    raft["x"][5] += 100.0
    params = full_params(time_step=60.0, contact_modulus=1e9)
    with Engine(SELF, params, log) as engine:
        engine.load(raft)
        with pytest.raises(EngineError, match=r"Element \d+ ran away .* last force"):
            engine.run(1000)


def test_a_force_that_is_not_finite_names_the_element(log: Path) -> None:
    pair = discs([0.0, 1500.0], [0.0, 0.0])
    pair["thickness"][:] = 1e306
    with Engine(SELF, full_params(time_step=1.0), log) as engine:
        engine.load(pair)
        with pytest.raises(EngineError, match=r"Element [12] became non-finite at .* in step 1"):
            engine.run(10)


def test_a_bond_beyond_the_reach_is_reported(log: Path) -> None:
    pair = discs([0.0, 2000.0], [0.0, 0.0])
    pair["u"][1] = 1.0
    params = full_params(
        time_step=1.0, bonds=True, reach=1.2, compressive_strength=1e12, young_modulus=1e3
    )
    with Engine(SELF, params, log) as engine:
        engine.load(pair, bonded(pair))
        with pytest.raises(EngineError, match="between elements [12] and [12].*longer reach"):
            engine.run(1000)


def refusal(engine: Engine, elements, bonds=None, contacts=None) -> str:
    with pytest.raises(FloeError) as caught:
        engine.load(elements, bonds, contacts)
    return str(caught.value)


def test_what_cannot_be_is_refused(log: Path, tmp_path: Path) -> None:
    raft = lattice(3, 2)
    table = bonded(raft)
    with Engine(SELF, full_params(time_step=1.0, bonds=True), log) as engine:
        wrong = raft | {"mass": raft["mass"] * np.where(raft["id"] == 3, np.nan, 1)}
        assert refusal(engine, wrong, table) == "mass of element 3 must be above 0, not nan."
        swapped = raft | {"id": raft["id"][::-1]}
        assert "ascending" in refusal(engine, swapped)
        twice = {name: np.concatenate([v, v[:1]]) for name, v in table.items()}
        assert "twice" in refusal(engine, raft, twice)
        gone = table | {"crack_a": table["crack_a"] + 1.0}
        assert "crack_a + crack_b of the bond 1-2" in refusal(engine, raft, gone)
        stranger = table | {"id_hi": np.where(table["id_hi"] == 2, 77, table["id_hi"])}
        assert "Element 77 of a pair does not exist" in refusal(engine, raft, stranger)
        pair = {"id_lo": [1], "id_hi": [2], "slip": [0.0], "rest_overlap": [0.0]}
        both = {name: np.array(v) for name, v in pair.items()}
        assert "bonded and in contact at once" in refusal(engine, raft, table, both)
        far = raft | {"x": raft["x"] * 3}
        assert "outside of the neighbour lists" in refusal(engine, far, table)
    strong = full_params(time_step=1.0, bonds=True, compressive_strength=1e30)
    with Engine(SELF, strong, log) as engine:
        assert "beyond the 4 that neighbour lists cover" in refusal(engine, raft, table)
    with Engine(SELF, full_params(time_step=1.0), tmp_path / "no" / "log") as engine:
        assert "log cannot be written: No such file" in refusal(engine, raft)
    (tmp_path / "log").mkdir()
    with Engine(SELF, full_params(time_step=1.0), tmp_path / "log") as engine:
        assert "log cannot be written: Is a directory" in refusal(engine, raft)
    with Engine(SELF, full_params(time_step=1.0, wind=True), log) as engine:
        engine.load(raft)
        with pytest.raises(FloeError, match="need forcing"):
            engine.run(1)
        with pytest.raises(FloeError, match="no wind_u"):
            engine.set_forcing(Forcing(np.zeros(1), np.zeros(1), np.zeros(1), {}))


@pytest.mark.parametrize(
    ("key", "value", "sentence"),
    [
        ("young_modulus", -1.0, "young_modulus must be above 0, not -1.0."),
        ("time_step", math.nan, "time_step must be finite, not nan."),
        ("poisson_ratio", 0.5, "poisson_ratio must be below 0.5, not 0.5."),
        ("friction_angle", 0.0, "friction_angle must be above 0, not 0.0."),
        ("friction_coefficient", -0.1, "friction_coefficient must not be negative, not -0.1."),
    ],
)
def test_bad_parameters_are_refused(key: str, value: float, sentence: str) -> None:
    with pytest.raises(FloeError) as caught:
        full_params(**{"time_step": 1.0, key: value})
    assert str(caught.value) == sentence


def test_numbers_of_numpy_are_numbers(log: Path) -> None:
    params = full_params(time_step=np.float64(1.0), contact_damping=np.float64(0.0))
    with Engine(SELF, params, log) as engine:
        engine.load(lattice(2, 1))
        engine.run(1)


@pytest.mark.parametrize(
    "use",
    [
        Engine.elements,
        Engine.bonds,
        Engine.contacts,
        Engine.wall_contacts,
        Engine.wall_forces,
        Engine.diagnostics,
        lambda engine: engine.run(1),
        lambda engine: engine.remove(np.array([1])),
        lambda engine: engine.set_forcing(uniform()),
    ],
)
def test_an_engine_without_elements_says_so(log: Path, use: Callable[[Engine], object]) -> None:
    engine = Engine(SELF, full_params(time_step=1.0), log)
    with pytest.raises(EngineError, match="holds no elements"):
        use(engine)
    engine.load(lattice(2, 1))
    use(engine)
    engine.close()
    with pytest.raises(EngineError, match="holds no elements"):
        use(engine)
    engine.close()
