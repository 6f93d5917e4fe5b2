"""Part 6: what a step costs, by joints and by planets."""

from __future__ import annotations

from benchmarks.suite.cases import Counted
from benchmarks.suite.rows import Row
from benchmarks.suite.timing import (
    divide_times,
    measure_seconds,
    print_progress,
    processor_s,
    run_in_turn,
)
from crosscheck.analytic.model import PhysicalModel
from crosscheck.cli.files.template import example_arm
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.loading import load_scenario

TABLE = "joints and planets"
STEPS, STEP_S = 100_000, 1e-6
JOINTS, PLANETS = (1, 2, 4, 6), (2, 4, 6)
USUAL_PLANETS, USUAL_JOINTS = 3, 2
COUNTED: tuple[Counted, ...] = ("lumped", "free")


def measure(repeats: int) -> list[Row]:
    """Arms of one to six joints with three planets each; then two joints of two to six planets."""
    sizes = [(joints, USUAL_PLANETS, counted) for joints in JOINTS for counted in COUNTED]
    sizes += [(USUAL_JOINTS, planets, "free") for planets in PLANETS]
    models = {_name(*size): build_model(*size) for size in sizes}
    for name, model in models.items():
        print_progress(f"{name}: {measure_seconds(model.simulate):.1f} s with what it compiles")
    runs = {name: model.simulate for name, model in models.items()}
    times = divide_times(run_in_turn(runs, repeats, processor_s), dict.fromkeys(runs, STEPS))
    first = _name(*sizes[0])
    return [
        Row(
            TABLE,
            name,
            "simulate(), per step",
            name_times.median * 1e9,
            "ns",
            first,
            name_times.median_ratio(times[first]),
            spread=name_times.spread,
        )
        for name, name_times in times.items()
    ]


def build_model(joints: int, planets: int, counted: Counted) -> PhysicalModel:
    """The template's arm with as many planets in every joint, whether or not they would clear."""
    arm = example_arm("sizes", joints)
    stages = tuple(joint.model_copy(update={"planet_count": planets}) for joint in arm.joints)
    update = {"duration_s": STEPS * STEP_S, "step_s": STEP_S, "record_every": STEPS}
    scenario = load_scenario("constant-torque").model_copy(update=update)
    widened = arm.model_copy(update={"joints": stages})
    return PhysicalModel(widened, scenario, switches(planets=counted))


def _name(joints: int, planets: int, counted: str) -> str:
    return f"{joints} joint{'s' * (joints > 1)}, {planets} planets, {counted}"
