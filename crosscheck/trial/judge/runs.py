"""Runs of equations on trial beside those of the engines with the same integrator and step."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from crosscheck.checks.scales import meaningful
from crosscheck.checks.trajectories import UNITS, Pair, same_step, size
from crosscheck.findings import About, Finding, Key
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import Case
from crosscheck.planning.comparison import Comparison, Results
from crosscheck.planning.plan import nudged
from crosscheck.registry import MODELS, same_integrator
from crosscheck.runner.tasks import RunKey, Simulation
from crosscheck.trial.judge.bench import Bench

FAMILY = "trial-run"
RIGID = ("theta", "theta_dot", "kinetic_energy")
MESH = ("x_sp", "x_pr")


def run_comparisons(bench: Bench, scenario: Scenario, level: str) -> Iterator[Comparison]:
    """A scenario by the equations and by each engine that takes the same steps."""
    case = bench.case._replace(scenario=scenario)
    quantities = RIGID if level else (*RIGID, *MESH) if bench.frame.layout.meshing else RIGID
    for engine in _steppers(bench, level):
        for quantity in quantities:
            yield _same_steps(bench, case, engine, quantity)


def _steppers(bench: Bench, level: str) -> tuple[str, ...]:
    if not level:
        return same_integrator()
    return tuple(name for name in bench.engines(level) if MODELS[name].order == 4)


def _same_steps(bench: Bench, case: Case, engine: str, quantity: str) -> Comparison:
    name = case.scenario.name
    yours = Simulation(RunKey(name, bench.name), case)
    theirs = Simulation(RunKey(name, engine), case)
    repeated = Simulation(RunKey(name, engine, "nudged"), nudged(case))
    key = Key(FAMILY, name, quantity, bench.name, engine)

    def judged(about: About, results: Results) -> Finding:
        one: Any = results.need(yours)
        other, moved = results.need(theirs), results.need(repeated)
        widest = meaningful(quantity, case.arm, case.scenario, size(other, quantity))
        return same_step(about, one, other, Pair(other, moved), widest)

    about = About(key, UNITS[quantity], "largest absolute difference")
    return Comparison(about, (yours, theirs, repeated), judged)
