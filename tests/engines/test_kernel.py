"""Machine code of runs against that of single states, and bit for bit against its own text.

Single states are those that other engines are asked for; by Python the kernels' text is run, every
operation rounded as IEEE 754 says.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.analytic.kernel.adaptive_kernel import NEAR_S, build_adaptive_program
from crosscheck.analytic.kernel.batch import (
    BLOCK_LANES,
    Batch,
    contiguous_table,
    make_aligned_zeros,
    number_rows,
)
from crosscheck.analytic.kernel.equations import KernelEquations
from crosscheck.analytic.kernel.program import (
    Program,
    build_states_program,
    build_steps_program,
    compile_program,
)
from crosscheck.analytic.model import AnalyticModel
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.interface import STATE_ABILITIES
from crosscheck.models.loading import Case, load_arm
from crosscheck.planning.arms import switch_combinations
from crosscheck.registry import build
from tests.any_arms import any_arms
from tests.arms import random_arm
from tests.draws import examples
from tests.faults.kernels import keep_nothing
from tests.interpreted import addresses, exact_fma, fma, interpreted
from tests.judged import compare_states
from tests.loops import require_items
from tests.mixed_arms import scenario

STATES = 9  # one more than a block has lanes
STEP_S = 1e-5
EPS = float(np.finfo(float).eps)
ROUNDING = 1e-13  # of the largest sum of a kind: a few hundred roundings; 9e-16 was measured
STEPS = (0, 700)  # at which the clock stands
LEVELS = ("links", "carriers", "armature", "coupled")


EVERY_SWITCH = list(
    dict.fromkeys(
        each.model_copy(update={"ring_rate": rate})
        for each in switch_combinations()
        for rate in ("eq13", "corrected")
    )
)


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
    start = {
        "theta_rad": draw.uniform(-2, 2, joints).tolist(),
        "theta_dot_rad_per_s": draw.uniform(-1, 1, joints).tolist(),
        "sun_planet_offset_m": draw.uniform(-4e-6, 4e-6, joints).tolist(),
    }
    grid = {"duration_s": steps * STEP_S, "step_s": STEP_S}
    return scenario(**grid, drive=drives(joints)[drive], start=start)


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

    @property
    def equations(self) -> KernelEquations:
        """The kernel's."""
        return self.model.equations


@dataclass(frozen=True)
class ByTerms(At):
    """The same, run by its terms."""

    @property
    def equations(self) -> KernelEquations:
        """In the layout's coordinates."""
        return self.model.term_equations


def states(model: AnalyticModel) -> list[At]:
    """At random, meshes in and out of contact."""
    draw, layout = np.random.default_rng(3), model.layout
    scale = np.where(layout.angular, 1.0, 1e-4)
    return [At(model, *(scale * draw.normal(size=(2, len(layout))))) for _ in range(STATES)]


def misses(model: AnalyticModel, lanes: int, kind: type[At] = At) -> list[str]:
    """Accelerations and mesh forces of runs that are not those of single states."""
    found, at = list[str](), [kind(model, state.q, state.v) for state in states(model)]
    for steps in STEPS:
        whole, t = Batch(at, lanes), steps * STEP_S
        whole.step_count = steps
        records = whole.advance(1, 0)
        # The lanes of a block do the same bit for bit; the clock at 0 tells fewer laws apart.
        for place in (0, STATES - 2, STATES - 1) if steps else (1,):
            right = model.states.evaluate(t, at[place].q, at[place].v)
            mass, made = right.mass_matrix, records.a[0, :, place]
            size = np.abs(mass) @ np.abs(right.acceleration)
            for of in (model.layout.angular, ~model.layout.angular):
                off = (mass @ (made - right.acceleration))[of]
                found += _missed(f"accelerations at {t}", off, size[of])
            off = records.forces[0, :, place] - right.mesh_forces
            found += _missed(f"forces at {t}", off, np.abs(right.mesh_forces))
    return found


def differing(model: AnalyticModel, engine: str) -> list[str]:
    """Quantities of single states in which an engine differs."""
    other = build(engine, model.arm, model.scenario, model.switches)
    findings = compare_states("test", [model, other], STATE_ABILITIES, 2, 3)
    return [finding.id for finding in findings if finding.verdict != "agree"]


def _missed(name: str, off: np.ndarray, size: np.ndarray) -> Iterator[str]:
    """Of one kind of quantity: it has one scale, for a component may vanish by chance."""
    if off.size and not np.abs(off).max() <= ROUNDING * size.max():
        yield f"{name}: {off} of {size}"


def model_on(arm: Arm, drive: str, laws: Switches) -> AnalyticModel:
    found = build("analytic:physical", arm, experiment(drive, len(arm.joints)), laws)
    assert isinstance(found, AnalyticModel)
    return found


@contextmanager
def compiled_quickly() -> Iterator[None]:
    """No level of optimisation changes a bit (tests/tool/test_machine_code.py)."""
    with pytest.MonkeyPatch.context() as patch:
        keep_nothing(patch)
        yield


@pytest.mark.parametrize("place", range(len(EVERY_SWITCH)))
def test_every_switch_on_arms_of_every_size(place):
    most = (1, 2, 3)[place % 3]  # of up to 7 joints below
    model = model_on(random_arm(place, most), DRIVES[place % len(DRIVES)], EVERY_SWITCH[place])
    with compiled_quickly():
        assert misses(model, (1, BLOCK_LANES)[place % 2]) == []
        assert differing(model, "pinocchio:gears") == []


@pytest.mark.slow
@settings(max_examples=examples(2, 30), database=None)
@given(data=st.data())
def test_arms_that_nobody_chose(data):
    arm = data.draw(any_arms(data.draw(st.integers(1, 7)), unlike=True))
    usual = usual_switches(arm)
    lumped = usual.planets == "lumped"
    laws = data.draw(st.sampled_from([s for s in EVERY_SWITCH if lumped or s.planets == "free"]))
    drive, lanes = data.draw(st.sampled_from(DRIVES)), data.draw(st.sampled_from([1, BLOCK_LANES]))
    with compiled_quickly():
        assert misses(model_on(arm, drive, laws), lanes) == []


@pytest.mark.parametrize("lanes", [1, BLOCK_LANES])
@pytest.mark.parametrize("level", LEVELS)
def test_rigid_levels(level, lanes):
    arm = random_arm(8, 7, all_geared=True)
    with compiled_quickly():
        model = build(f"analytic:{level}", arm, experiment("pd", len(arm.joints)))
        assert misses(model, lanes) == []


def cases() -> dict[str, tuple[str, Case]]:
    """Structures that have much in them."""
    probe, unlike, apart = map(load_arm, ("probe", "three-unlike", "planets-apart"))
    tabled = load_arm("direct-between")
    mixed = random_arm(87, 5)
    geared = "analytic:physical"

    def case(arm: Arm, drive: str, **laws: str) -> Case:
        return Case(arm, experiment(drive, len(arm.joints)), usual_switches(arm, **laws))

    return {
        "play": (geared, case(probe, "pd")),
        "tanh": (geared, case(probe, "table", dead_zone="tanh", ring_rate="eq13")),
        "waves": (geared, case(unlike, "sqrt_time", phase="omega_t", damping="contact")),
        "free": (geared, case(apart, "constant", mesh_work="conservative")),
        "table": (geared, case(tabled, "pd", mesh_work="conservative")),
        "mixed": (geared, case(mixed, "time")),
        "printed": ("analytic:printed", case(load_arm("paper-labelled"), "pd", phase="omega_t")),
        "coupled": ("analytic:coupled", case(random_arm(8, 7, all_geared=True), "pd")),
    }


CASES = cases()


@lru_cache
def model_of(name: str) -> AnalyticModel:
    """Of one of CASES."""
    kind, case = CASES[name]
    found = build(kind, *case)
    assert isinstance(found, AnalyticModel)
    return found


@pytest.fixture(params=CASES)
def model(request: pytest.FixtureRequest) -> AnalyticModel:
    return model_of(request.param)


@pytest.mark.parametrize("kind", [At, ByTerms])
@pytest.mark.parametrize("lanes", [1, BLOCK_LANES])
def test_kernels_say_what_single_states_say(model, lanes, kind):
    assert misses(model, lanes, kind) == []


def test_the_c_library_rounds_a_product_and_a_sum_once():
    rng = np.random.default_rng(5)
    a, b = rng.normal(size=(2, 2000)) * 2.0 ** rng.integers(-60, 60, size=(2, 2000))
    near = -a * b * (1 + rng.integers(-3, 4, size=2000) * EPS)  # where all but the error cancels
    for numbers in zip([*a, 3.0], [*b, 1 / 3], [*near, 0.0], strict=True):
        assert fma(*numbers) == exact_fma(*numbers)


def both(program: Program, function: str, arguments: tuple[Any, ...]) -> tuple[Any, Any]:
    """Arguments after machine code and after Python have worked on copies of them."""
    ours, theirs = (
        tuple(copied(a) if isinstance(a, np.ndarray) else a for a in arguments) for _ in range(2)
    )
    compile_program(program)[function](*addresses(ours))
    interpreted(program)[function](*theirs)
    return ours, theirs


def copied(array: np.ndarray) -> np.ndarray:
    """Where a kernel expects an array to begin."""
    room = make_aligned_zeros(1, array.size)[0]
    room[:] = array.reshape(-1)
    return room.reshape(array.shape)


def assert_same_bits(ours: tuple[Any, ...], theirs: tuple[Any, ...]) -> None:
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_array_equal(one, other)


def steps_arguments(at: list[At], lanes: int, steps: int) -> tuple[Any, ...]:
    """Of ``advance``: a record at every second step."""
    batch = Batch(at, lanes)
    blocks, n = len(batch.work), len(batch.structure.coordinates)
    times, torques = contiguous_table(at[0].model.drive)
    out = np.zeros((steps // 2, 3 * n + len(batch.structure.meshes), blocks * lanes))
    work = np.array(batch.work).reshape(-1)
    table = times, torques, times.size, np.zeros(len(torques))
    return work, blocks, STEPS[-1], len(out), 2, STEP_S, *table, out


@pytest.mark.parametrize("kind", [At, ByTerms])
@pytest.mark.parametrize("lanes", [1, BLOCK_LANES])
def test_steps_are_their_texts_bit_for_bit(model, lanes, kind):
    at = [kind(model, state.q, state.v) for state in states(model)][: 2 if lanes == 1 else None]
    equations = at[0].equations
    program = build_steps_program(equations.structure, equations.record_map(), lanes)
    ours, theirs = both(program, "advance", steps_arguments(at, lanes, 2 if lanes > 1 else 6))
    assert np.isfinite(ours[-1]).all()
    assert_same_bits(ours, theirs)


def test_states_are_their_texts_bit_for_bit(model):
    equations = model.term_equations
    program = build_states_program(equations.structure)
    for at in require_items(states(model)[:3]):
        rest = np.zeros(program.leading_rows - 2 * len(at.q))
        w = np.concatenate([at.q, at.v, rest, *number_rows(program, equations.numbers)])
        table = np.linspace(3.0, 7.0, len(model.arm.joints))
        assert_same_bits(*both(program, "evaluate", (w, 0.7, 0.7**0.5, table, 0.0, 0.0)))


def precise_arguments(model: AnalyticModel, records: int, interval: float) -> tuple[Any, ...]:
    """Of ``follow``, from the model's start."""
    equations = model.equations
    structure = equations.structure
    program = build_adaptive_program(structure, equations.record_map())
    n, m = len(structure.coordinates), len(structure.meshes)
    state = [equations.to_kernel(x) for x in model.start()]
    rest, numbers = (
        np.zeros(program.leading_rows - 3 * n - 3 * m),
        number_rows(program, equations.numbers),
    )
    w = np.concatenate([*state, np.zeros(n + 2 * m), model.gears.b, rest, *numbers])
    times, torques = contiguous_table(model.drive)
    table = times, torques, times.size, np.zeros(len(torques))
    room = np.zeros(2 * m), np.zeros(2 * m), np.zeros((records, 3 * n + m)), np.zeros(2)
    return w, records, interval, 1e-9, np.full(2 * n, 1e-13), NEAR_S, *table, *room


@pytest.mark.parametrize("name", ["play", "table", "waves"])
def test_precise_runs_are_their_texts_bit_for_bit(name):
    model = model_of(name)
    program = build_adaptive_program(model.equations.structure, model.equations.record_map())
    ours, theirs = both(program, "follow", precise_arguments(model, 3, 5e-5))
    assert ours[-1][0] > 0
    assert_same_bits(ours, theirs)


def test_a_contact_is_looked_for_first_where_a_straight_line_changes_sign():
    equations = model_of("play").equations
    program = build_adaptive_program(equations.structure, equations.record_map())
    crossing = interpreted(program)["crossing"]
    low = np.ones(2 * len(equations.structure.meshes))
    high = low.copy()
    assert crossing(low, high) == 1.0
    high[1] = -1 / 3  # after three quarters
    assert crossing(low, high) == pytest.approx(0.75)
    low[0], high[0] = -1.0, 4.0  # after a fifth
    assert crossing(low, high) == pytest.approx(0.2)
