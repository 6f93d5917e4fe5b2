"""Part 1: one trajectory by the model's own `simulate`, against the scalar C reference."""

from __future__ import annotations

import numpy as np

from benchmarks.suite.c_numbers import NotCovered
from benchmarks.suite.c_reference import NoCompiler, ScalarRun
from benchmarks.suite.cases import Counted, build_long_run
from benchmarks.suite.rows import Row, absent_row
from benchmarks.suite.timing import Times, divide_times, processor_s, run_in_turn
from crosscheck.analytic.kernel.batch import Batch
from crosscheck.analytic.model import PhysicalModel

TABLE = "single kernel"
TARGETS: dict[Counted, float] = {"lumped": 1.15, "free": 1.3}
STEPS = {2: 500_000, 6: 100_000}  # long beside what a run costs before its first step
SHORT_RATIO = 25  # their share of a run whose states are compared
C, FAST = "scalar C", "simulate()"


def measure(repeats: int) -> list[Row]:
    """Two joints and six, lumped and free."""
    rows = []
    for joints, steps in STEPS.items():
        for counted, target in TARGETS.items():
            model, short = (
                build_long_run(joints, counted, n) for n in (steps, steps // SHORT_RATIO)
            )
            rows += _case(model, short, target, repeats)
    return rows


def _case(model: PhysicalModel, short: PhysicalModel, target: float, repeats: int) -> list[Row]:
    case = f"{len(model.arm.joints)} joints, {model.switches.planets}"
    steps = dict.fromkeys((FAST, C), model.scenario.steps)
    runs = {FAST: model.simulate}
    try:
        reference = ScalarRun(model)
    except (NoCompiler, NotCovered) as reason:
        times = divide_times(run_in_turn(runs, repeats, processor_s), steps)
        return [*(_step_row(case, n, times[n]) for n in runs), absent_row(TABLE, case, str(reason))]
    times = divide_times(run_in_turn({**runs, C: reference.run}, repeats, processor_s), steps)
    kernel_row = _step_row(case, FAST, times[FAST])._replace(
        against=C, ratio=times[FAST].median_ratio(times[C]), target=target
    )
    return [kernel_row, _step_row(case, C, times[C]), *_differences(case, short)]


def _step_row(case: str, who: str, times: Times) -> Row:
    return Row(TABLE, case, f"{who}, per step", times.median * 1e9, "ns", spread=times.spread)


def _differences(case: str, model: PhysicalModel) -> list[Row]:
    """Of the C reference's states from those of ``simulate``."""
    reference = ScalarRun(model)
    reference.run()
    by_c = largest_difference(model, reference.states()[0], simulate_states(model))
    return [Row(TABLE, case, f"{C}: largest difference from {FAST}", by_c, "of size")]


def simulate_states(model: PhysicalModel) -> np.ndarray:
    """Coordinates (records, n) of a model's own run."""
    parts = Batch([model], lanes=1).run(
        model.scenario.steps // model.scenario.stride, model.scenario.stride, 10**6
    )
    return np.concatenate([part.q[:, :, 0] for part in parts])


def largest_difference(model: PhysicalModel, q: np.ndarray, reference: np.ndarray) -> float:
    """Of angles over the largest of them, or of displacements over the play: the larger."""
    angular, play = model.layout.angular, float(model.gears.b.min())
    difference = np.abs(q - reference)
    of_angles = difference[:, angular].max() / np.abs(reference[:, angular]).max()
    return float(max(of_angles, difference[:, ~angular].max() / play))
