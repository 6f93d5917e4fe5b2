"""Part 1: one trajectory by the model's own `simulate`, against the scalar C reference."""

from __future__ import annotations

import numpy as np

from analytic.model import PhysicalModel
from benchmarks.suite.c_numbers import NotCovered
from benchmarks.suite.c_reference import NoCompiler, Scalar
from benchmarks.suite.cases import Counted, long_run
from benchmarks.suite.rows import Row, absent
from benchmarks.suite.timing import Times, in_turn, per_unit, processor

TABLE = "single kernel"
TARGETS: dict[Counted, float] = {"lumped": 1.15, "free": 1.3}
STEPS = {2: 500_000, 6: 100_000}  # long beside what a run costs before its first step
SHORTER = 25  # the plain kernel's share of them: it is the slow one
C, PLAIN, FAST = "scalar C", "plain kernel", "simulate()"


def measure(repeats: int) -> list[Row]:
    """Two joints and six, lumped and free."""
    rows = []
    for joints, steps in STEPS.items():
        for counted, target in TARGETS.items():
            model, short = (long_run(joints, counted, n) for n in (steps, steps // SHORTER))
            rows += _case(model, short, target, repeats)
    return rows


def _case(model: PhysicalModel, short: PhysicalModel, target: float, repeats: int) -> list[Row]:
    case = f"{len(model.arm.joints)} joints, {model.switches.planets}"
    steps = {FAST: model.scenario.steps, PLAIN: short.scenario.steps, C: model.scenario.steps}
    runs = {FAST: model.simulate, PLAIN: short.integrated}
    try:
        reference = Scalar(model)
    except (NoCompiler, NotCovered) as reason:
        times = per_unit(in_turn(runs, repeats, processor), steps)
        return [*(_per_step(case, n, times[n]) for n in runs), absent(TABLE, case, str(reason))]
    times = per_unit(in_turn({**runs, C: reference.run}, repeats, processor), steps)
    targets = {FAST: target, PLAIN: None}
    held = [
        _per_step(case, who, times[who])._replace(
            against=C, ratio=times[who].over(times[C]), target=most
        )
        for who, most in targets.items()
    ]
    return [*held, _per_step(case, C, times[C]), *_differences(case, short)]


def _per_step(case: str, who: str, times: Times) -> Row:
    return Row(TABLE, case, f"{who}, per step", times.median * 1e9, "ns", spread=times.spread)


def _differences(case: str, model: PhysicalModel) -> list[Row]:
    """Of the C reference's states, and of the fast kernel's, from the plain kernel's."""
    reference = Scalar(model)
    reference.run()
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
    """Of angles over the largest of them, or of displacements over the play: the larger."""
    angular, play = model.layout.angular, float(model.gears.b.min())
    apart = np.abs(q - reference)
    of_angles = apart[:, angular].max() / np.abs(reference[:, angular]).max()
    return float(max(of_angles, apart[:, ~angular].max() / play))
