"""Part 1: one trajectory by the model's own `simulate`, against the scalar C reference."""

from __future__ import annotations

import numpy as np

from analytic.model import PhysicalModel
from benchmarks.suite.c_numbers import NotCovered
from benchmarks.suite.c_reference import NoCompiler, Scalar
from benchmarks.suite.cases import Counted, long_run
from benchmarks.suite.rows import Row, absent
from benchmarks.suite.timing import Times, in_turn

TABLE = "single kernel"
TARGETS: dict[Counted, float] = {"lumped": 1.15, "free": 1.3}
STEPS = {2: 500_000, 6: 100_000}  # long beside what a run costs before its first step
C, PLAIN, FAST = "scalar C", "plain kernel", "simulate()"


def measure(repeats: int) -> list[Row]:
    """Two joints and six, lumped and free."""
    rows = []
    for joints, steps in STEPS.items():
        for counted, target in TARGETS.items():
            rows += _case(long_run(joints, counted, steps), counted, target, repeats)
    return rows


def _case(model: PhysicalModel, counted: Counted, target: float, repeats: int) -> list[Row]:
    case = f"{len(model.arm.joints)} joints, {counted}"
    runs = {FAST: model.simulate, PLAIN: model.integrated}
    try:
        reference = Scalar(model)
    except (NoCompiler, NotCovered) as reason:
        times = in_turn(runs, repeats)
        rows = [_per_step(case, name, times[name], model.scenario.steps) for name in runs]
        return [*rows, absent(TABLE, case, str(reason))]
    times = in_turn({**runs, C: reference.run}, repeats)
    fast, c = times[FAST], times[C]
    steps = model.scenario.steps
    return [
        _per_step(case, C, c, steps),
        _per_step(case, FAST, fast, steps)._replace(against=C, ratio=fast.over(c), target=target),
        _per_step(case, PLAIN, times[PLAIN], steps)._replace(against=C, ratio=times[PLAIN].over(c)),
        *_differences(case, model, reference),
    ]


def _per_step(case: str, who: str, times: Times, steps: int) -> Row:
    return Row(TABLE, case, f"{who}, per step", times.median / steps * 1e9, "ns", spread=times.spread)


def _differences(case: str, model: PhysicalModel, reference: Scalar) -> list[Row]:
    """Of the C reference's states, and of the fast kernel's, from the plain kernel's."""
    plain, _ = model.integrated()
    run = model.simulate()
    angles = plain[:, model.layout.theta]
    by_c = largest_difference(model, reference.states()[0], plain)
    by_fast = float(np.abs(run["theta"].to_numpy() - angles).max() / np.abs(angles).max())
    return [
        Row(TABLE, case, f"{C}: largest difference from the plain kernel", by_c, "of size"),
        Row(TABLE, case, f"{FAST}: that of the angles", by_fast, "of size"),
    ]


def largest_difference(model: PhysicalModel, q: np.ndarray, reference: np.ndarray) -> float:
    """Of angles over the largest of them, or of displacements over the play, whichever is larger."""
    angular, play = model.layout.angular, float(model.gears.b.min())
    apart = np.abs(q - reference)
    of_angles = apart[:, angular].max() / np.abs(reference[:, angular]).max()
    return float(max(of_angles, apart[:, ~angular].max() / play))
