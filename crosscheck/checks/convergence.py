"""Runs at finer and finer steps: their order, and of free motions their energy."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crosscheck.checks.answers import ask
from crosscheck.checks.engines import STEPS
from crosscheck.checks.robot_states import LARGEST_TOLERANCE, TOLERANCE
from crosscheck.checks.sampled import (
    ExperimentPlan,
    RobotLevel,
    Subjects,
    find_experiments,
)
from crosscheck.checks.scales import check_share
from crosscheck.checks.trajectories import largest_difference
from crosscheck.findings import ComparisonKey, Finding, Subject, make_check, make_measurement
from crosscheck.models.robot.integration import integrate
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import remove_friction
from crosscheck.planning.comparison import Comparison, make_comparison

if TYPE_CHECKING:
    import xarray as xr

# Three grids in their asymptotic range give the order to a few per cent of one.
ORDER_TOLERANCE = 0.2
ORDER_LEVELS, ORDER_QUANTITY = 3, "x_sp"  # runs of an arm at h, h/2, h/4, and what shows the order
FORMAL, HALVINGS, MOST_HALVINGS = 4, 3, 6
ROUNDED = 1e-11  # largest difference that is rounding grown by M's inverse, over a run's motion


def refined_ends(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """Coordinates, then the energy, of the first state (row 0) and of its run at each step.

    Where terms of two orders cancel, a few halvings show an order that no finer ones confirm. So
    steps whose order is not the method's are halved further, before that is a finding.
    """
    q, v, _, torques = case.states.first(1)
    rows = [np.append(q, ask(model, "energy", (1,), q, v))]
    for halving in range(MOST_HALVINGS + 1):
        steps = STEPS * 2**halving
        ends = integrate(model, q, v, lambda time: 0 * torques, case.run_s, steps)
        rows.append(np.append(ends[0], ask(model, "energy", (1,), *ends)))
        observed = observe_order(np.array(rows))
        is_off = observed.is_settled and observed.error > ORDER_TOLERANCE
        if halving >= HALVINGS and not is_off:
            break
    return np.array(rows)


def frictionless_ends(model: RobotModel, case: RobotLevel) -> np.ndarray:
    """The same of the robot without friction, which would use its energy up."""
    return refined_ends(type(model)(remove_friction(case.robot), case.level), case)


def plan(subjects: Subjects) -> Iterator[Comparison | str]:
    """Comparisons of runs with the integrator's order, and of a robot's with their own energy."""
    for experiment in find_experiments(subjects, "order"):
        for model in experiment.models.same:
            yield _plan_order(experiment, model)
    for sampled in subjects.robots:
        case = sampled.setting
        if case.level == "geared" or not case.has_runs:
            continue
        kept = frictionless_ends if case.robot.friction.any() else refined_ends
        metric = f"free motion of {case.run_s:.3g} s in {STEPS} to {STEPS * 2**HALVINGS} steps"
        run = replace(sampled, where=f"{sampled.where}/run")
        against = f"order of convergence {FORMAL}"
        given = "order-of-convergence", [refined_ends], _check_order, metric, against
        yield run.plan_law(*given, family="order")
        yield run.plan_law("energy", [kept], _check_energy, metric)
    if any(sampled.setting.robot.friction.any() for sampled in subjects.robots):
        yield "energy of runs is asked of the robot without its friction"
    if any(sampled.setting.level == "geared" for sampled in subjects.robots):
        why = "teeth that part have kinks, and springs and dampers energy of their own"
        yield f"geared: order and energy are not asked of runs, since {why}"


def _plan_order(experiment: ExperimentPlan, model: str) -> Comparison:
    """The comparison of an arm's model, smooth or through impacts."""
    formal = experiment.models.order
    judge: Callable[..., Finding] = measure_impact_order
    metric = f"observed order in {ORDER_QUANTITY} from steps h, h/2, h/4"
    if experiment.name == "order-smooth":
        metric = f"distance of the observed order in {ORDER_QUANTITY} from the formal one"
        judge = partial(check_formal_order, formal=formal)
    key = ComparisonKey("order", experiment.name, "order-of-convergence", model)
    runs = [experiment.run(model, f"level-{level}") for level in range(ORDER_LEVELS)]
    about = Subject(key, "1", metric, f"order of convergence {formal}")
    return make_comparison(about, runs, judge)


def observed_order(*runs: xr.Dataset) -> float:
    """Observed order p from runs at h, h/2, h/4: differences shrink by 2^p (Richardson)."""
    first, second = (largest_difference(*pair, ORDER_QUANTITY) for pair in pairwise(runs))
    return math.log2(first / second) if first > 0 and second > 0 else math.nan


def check_formal_order(about: Subject, *runs: xr.Dataset, formal: int) -> Finding:
    """Check that runs show the integrator's order in smooth motion."""
    observed = observed_order(*runs)
    difference, basis = abs(observed - formal), "three grids in the asymptotic range"
    note = f"observed order {observed:.3f} from steps h, h/2, h/4"
    return make_check(about, measured=difference, tolerance=ORDER_TOLERANCE, basis=basis, note=note)


def measure_impact_order(about: Subject, *runs: xr.Dataset) -> Finding:
    """Measure the order of convergence through impacts."""
    note = "the dead zone's kink leaves less than the formal order"
    return make_measurement(about, measured=observed_order(*runs), note=note)


class ObservedOrder(NamedTuple):
    """Orders by which halving a step makes its error smaller, where the error is no rounding.

    What a term of one order more leaves in an order halves with the step: so the last order is as
    far from its limit as it is from the one before. A limit above the method's own order says that
    such a term still outweighs its errors, and of the method nothing.
    """

    orders: list[float]

    @property
    def limit(self) -> float:
        """The order of vanishing steps."""
        return 2 * self.orders[-1] - self.orders[-2] if len(self.orders) > 1 else np.inf

    @property
    def error(self) -> float:
        """How far the order of vanishing steps is from the method's."""
        return abs(self.limit - FORMAL)

    @property
    def is_settled(self) -> bool:
        """Whether the steps are fine enough to determine the limit."""
        is_near = abs(self.limit - self.orders[-1]) <= ORDER_TOLERANCE if self.orders else False
        return is_near and self.limit <= FORMAL + ORDER_TOLERANCE


def observe_order(rows: np.ndarray) -> ObservedOrder:
    """The orders of a model's runs, from the rows of ``refined_ends``."""
    ends = rows[1:, :-1]
    moved = float(np.abs(ends - rows[0, :-1]).max())
    differences = np.abs(np.diff(ends, axis=0)).max(axis=1)
    above = differences[differences > ROUNDED * moved]
    return ObservedOrder([float(order) for order in np.log2(above[:-1] / above[1:])])


def _check_order(about: Subject, rows: np.ndarray, case: RobotLevel) -> Finding:
    """Check the observed order against the method's, if the steps are fine enough to show it."""
    observed = observe_order(rows)
    if not observed.is_settled:
        shown = ", ".join(f"{order:.2f}" for order in observed.orders) or "none"
        note = f"not asked: the steps' differences are rounding, or too large; orders {shown}"
        return make_measurement(about, measured=0.0, note=note)
    before, last = observed.orders[-2:]
    return make_check(
        about,
        measured=observed.error,
        tolerance=ORDER_TOLERANCE,
        basis="the orders of two halvings tend to one as far from them as they are from each other",
        note=f"observed order {last:.3f} of the finest steps, {before:.3f} of those before",
    )


def _check_energy(about: Subject, rows: np.ndarray, case: RobotLevel) -> Finding:
    """The energy at the finest steps is that of the start, but for what their halving changes."""
    energies, size = rows[:, -1], float(case.sizes.energy[0])
    gained = abs(energies[-1] - energies[0]) / size
    truncated = abs(energies[-1] - energies[-2]) / size
    if truncated > LARGEST_TOLERANCE:
        note = f"not asked: halving the step changes {truncated:.1g} of the energy"
        return make_measurement(about, measured=gained, note=note)
    basis = f"{TOLERANCE:g} of the energy's size, and what the last halving of the step changed"
    return check_share(about, gained, TOLERANCE + truncated, basis)
