"""The specialised kernels against the plain one: accelerations, mesh forces and short runs.

Breadth is on the kernels' text run as Python; compiled, structures that have much in them at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from analytic import model as model_module
from analytic.ensemble import alone, trajectories
from analytic.fast import batch
from analytic.fast.batch import WIDE, Batch
from analytic.model import AnalyticModel
from crosscheck.registry import build
from models.arm import Arm
from models.loading import Case, load_arm
from models.planets import usual_switches
from models.scenario import Scenario
from models.switches import Switches, switches
from tests.any_arms import any_arms
from tests.arms import random_arm
from tests.planted.kernels import interpreted
from tests.rounded import DRAWS, ROUNDINGS, accelerations_and_forces, moved, rounded, run

STATES = 11  # more than a block has lanes
STEP_S = 1e-5
STEPS = (0, 700)  # at which the clock stands
LEVELS = ("links", "carriers", "armature", "coupled")
SINE = {"law": "sine", "mean_N_per_m": 9e7, "amplitude_N_per_m": 1.3e7}


def _every_switch() -> Iterator[Switches]:
    fields = {
        "phase": ("angle", "omega_t"),
        "ring_rate": ("eq13", "corrected"),
        "dead_zone": ("exact", "tanh"),
        "damping": ("always", "contact"),
        "planets": ("lumped", "free"),
        "mesh_work": ("paper", "conservative"),
    }
    for values in product(*fields.values()):
        try:
            yield switches(**dict(zip(fields, values, strict=True)))
        except ValidationError:
            continue  # no potential behind it


EVERY_SWITCH = list(_every_switch())


def drives(joints: int) -> dict[str, dict[str, Any]]:
    """Every law, other numbers for every joint."""
    falling = np.linspace(1.0, 0.4, joints)
    wave = {
        "kind": "sinusoid",
        "amplitude_N_m": (200 * falling).tolist(),
        "rate_rad_per_s": (90 * falling).tolist(),
    }
    return {
        "constant": {"kind": "constant", "torque_N_m": (100 * falling).tolist()},
        "pd": {
            "kind": "pd",
            "target_rad": (falling - 0.7).tolist(),
            "proportional_N_m_per_rad": (1000 * falling).tolist(),
            "derivative_N_m_s_per_rad": (400 * falling).tolist(),
        },
        "time": wave | {"argument": "time"},
        "sqrt_time": wave | {"argument": "sqrt_time"},
        "table": {
            "kind": "table",
            "time_s": [0.0, 1e-4, 1.1e-3, 1.0],
            "torque_N_m": [[0.0, 300.0 * f, -200.0 * f, 50.0] for f in falling],
        },
    }


DRIVES = tuple(drives(1))


def experiment(drive: str, joints: int, steps: int = 40) -> Scenario:
    """A short one from a start in motion."""
    draw = np.random.default_rng(joints)
    return Scenario.model_validate(
        {
            "schema_version": 1,
            "name": "test",
            "duration_s": steps * STEP_S,
            "step_s": STEP_S,
            "record_every": 10,
            "drive": drives(joints)[drive],
            "start": {
                "theta_rad": draw.uniform(-2, 2, joints).tolist(),
                "theta_dot_rad_per_s": draw.uniform(-1, 1, joints).tolist(),
                "sun_planet_offset_m": draw.uniform(-4e-6, 4e-6, joints).tolist(),
            },
        }
    )


def without_tables(arm: Arm) -> Arm:
    """Eq. 8 in place of tables, which no specialised kernel knows."""

    def replaced(value: Any) -> Any:
        if isinstance(value, dict):
            law = value.get("law") == "table"
            return SINE if law else {name: replaced(part) for name, part in value.items()}
        return [replaced(part) for part in value] if isinstance(value, (list, tuple)) else value

    return Arm.model_validate(replaced(arm.model_dump(exclude_none=True)))


@dataclass(frozen=True)
class At:
    """A model that starts at a state."""

    model: AnalyticModel
    q: np.ndarray
    v: np.ndarray

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """The state."""
        return self.q, self.v

    def __getattr__(self, name: str) -> Any:
        return getattr(self.model, name)


def states(model: AnalyticModel) -> list[At]:
    """At random, meshes in and out of contact."""
    draw, layout = np.random.default_rng(3), model.layout
    scale = np.where(layout.angular, 1.0, 1e-4)
    return [At(model, *(scale * draw.normal(size=(2, len(layout))))) for _ in range(STATES)]


def misses(model: AnalyticModel, lanes: int) -> list[str]:
    """Accelerations and mesh forces of a specialised kernel that are not the plain one's."""
    found, at = [], states(model)
    for steps in STEPS:
        whole = Batch(at, lanes)
        whole.done = steps
        records = whole.advance(1, 0)
        for place, state in enumerate(at):
            made = records.a[0, :, place], records.forces[0, :, place]
            found += _misses_at(state, steps * STEP_S, *made)
    return found


def _misses_at(at: At, t: float, a: np.ndarray, forces: np.ndarray) -> Iterator[str]:
    model, angular = at.model, at.model.layout.angular
    parts = (model.terms, model.gears, model.drive)
    right, right_forces = accelerations_and_forces(parts, t, at.q, at.v)
    apart, apart_forces = np.zeros_like(right), np.zeros_like(right_forces)
    for seed in range(DRAWS):
        state = rounded((at.q, at.v), np.random.default_rng(seed))
        other, other_forces = accelerations_and_forces(moved(model, seed), t, *state)
        apart = np.maximum(apart, abs(other - right))
        apart_forces = np.maximum(apart_forces, abs(other_forces - right_forces))
    for name, of in (("angles", angular), ("displacements", ~angular)):
        yield from _missed(f"{name} at {t}", a[of], right[of], apart[of])
    yield from _missed(f"forces at {t}", forces, right_forces, apart_forces)


def _missed(name: str, found: np.ndarray, right: np.ndarray, apart: np.ndarray) -> Iterator[str]:
    """Of one kind of quantity: it has one scale, for a component may vanish by chance."""
    if not right.size:
        return
    error, allowed = abs(found - right).max(), ROUNDINGS * apart.max()
    assert allowed <= 1e-6 * abs(right).max(), f"{name}: a tolerance that means nothing"
    if not error <= allowed:
        yield f"{name}: {error} > {allowed}"


def interpreted_misses(arm: Arm, drive: str, laws: Switches, lanes: int) -> list[str]:
    model = build("analytic:physical", arm, experiment(drive, len(arm.joints)), laws)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batch, "module_of", interpreted)
        patch.setattr(model_module, "compilable", lambda structure: True)  # nothing is compiled
        return misses(model, lanes)


@pytest.mark.parametrize("place", range(len(EVERY_SWITCH)))
def test_every_switch_on_arms_of_every_size(place):
    arm = without_tables(random_arm(place, 7))
    lanes = (1, WIDE)[place % 2]
    drive = DRIVES[place % len(DRIVES)]
    assert interpreted_misses(arm, drive, EVERY_SWITCH[place], lanes) == []


@settings(max_examples=25, derandomize=True, deadline=None, database=None)
@given(data=st.data())
def test_arms_that_nobody_chose(data):
    arm = without_tables(data.draw(any_arms(data.draw(st.integers(1, 7)), unlike=True)))
    usual = usual_switches(arm)
    laws = data.draw(st.sampled_from([s for s in EVERY_SWITCH if _fits(s, usual)]))
    drive, lanes = data.draw(st.sampled_from(DRIVES)), data.draw(st.sampled_from([1, WIDE]))
    assert interpreted_misses(arm, drive, laws, lanes) == []


def _fits(laws: Switches, usual: Switches) -> bool:
    return usual.planets == "lumped" or laws.planets == "free"


@pytest.mark.parametrize("lanes", [1, WIDE])
@pytest.mark.parametrize("level", LEVELS)
def test_rigid_levels(level, lanes):
    arm = random_arm(8, 7, all_geared=True)
    model = build(f"analytic:{level}", arm, experiment("pd", len(arm.joints)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batch, "module_of", interpreted)
        assert misses(model, lanes) == []


def compiled_cases() -> dict[str, tuple[str, Case]]:
    """Structures that have much in them."""
    probe, unlike, apart = map(load_arm, ("probe", "three-unlike", "planets-apart"))
    mixed = random_arm(87, 5)
    geared = "analytic:physical"

    def case(arm: Arm, drive: str, **laws: str) -> Case:
        return Case(arm, experiment(drive, len(arm.joints)), usual_switches(arm, **laws))

    return {
        "play": (geared, case(probe, "pd")),
        "tanh": (geared, case(probe, "table", dead_zone="tanh", ring_rate="eq13")),
        "waves": (geared, case(unlike, "sqrt_time", phase="omega_t", damping="contact")),
        "free": (geared, case(apart, "constant", mesh_work="conservative")),
        "mixed": (geared, case(mixed, "time")),
        "coupled": ("analytic:coupled", case(random_arm(8, 7, all_geared=True), "pd")),
    }


COMPILED = compiled_cases()


@pytest.fixture(scope="module", params=COMPILED)
def model(request: pytest.FixtureRequest) -> AnalyticModel:
    """One that runs on a compiled kernel."""
    name, case = COMPILED[request.param]
    found = build(name, *case)
    assert isinstance(found, AnalyticModel)
    assert found.structure is not None
    return found


@pytest.mark.parametrize("lanes", [1, WIDE])
def test_compiled_kernels_say_what_the_plain_one_says(model, lanes):
    assert misses(model, lanes) == []


@pytest.mark.parametrize("lanes", [1, WIDE])
def test_runs_are_the_plain_kernels_to_rounding(model, lanes):
    whole, scenario = Batch([model], lanes), model.scenario
    records = [whole.advance(scenario.steps // scenario.stride, scenario.stride)]
    records.append(whole.advance(1, 0))
    made = [np.concatenate([r[kind][:, :, 0] for r in records]) for kind in range(2)]
    right = model.integrated()
    apart = [np.zeros_like(each) for each in right]
    for seed in range(DRAWS):
        start = rounded(model.start(), np.random.default_rng(seed))
        other = run(moved(model, seed), scenario, start)
        apart = [np.maximum(a, abs(o - r)) for a, o, r in zip(apart, other, right, strict=True)]
    missed = [
        miss
        for name, *kinds in zip(("q", "v"), made, right, apart, strict=True)
        for of in (model.layout.angular, ~model.layout.angular)
        for miss in _missed(name, *(kind[:, of] for kind in kinds))
    ]
    assert missed == []


def test_what_is_recorded_is_what_the_plain_kernel_records(model, monkeypatch):
    one, (several,) = alone(model), trajectories([model])
    monkeypatch.setattr(AnalyticModel, "structure", None)
    plain = alone(model)
    for run_of in (one, several):
        assert run_of.attrs == plain.attrs
        assert set(run_of) == set(plain)
        for name, values in run_of.items():
            size = float(abs(plain[name]).max())
            # Forty steps of stiff teeth let a rounding grow a thousandfold at most.
            assert values.dims == plain[name].dims
            np.testing.assert_allclose(values, plain[name], rtol=0, atol=1e-8 * size, err_msg=name)
