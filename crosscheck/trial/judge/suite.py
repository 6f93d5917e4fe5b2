"""Every comparison of a trial: what the equations owe to themselves, then to the engines."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from crosscheck.checks.invariants import SYMMETRY
from crosscheck.checks.scales import meaningful
from crosscheck.checks.states import LOOSEST, scaled, usable
from crosscheck.checks.trajectories import UNITS, Pair, same_step, size
from crosscheck.findings import About, Finding, Key, checked, failed, measured_only
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.planning.comparison import Comparison, Results, answered
from crosscheck.planning.plan import nudged
from crosscheck.planning.state_suite import SampledModel, balances
from crosscheck.registry import MODELS, same_integrator
from crosscheck.runner.tasks import RunKey, Simulation
from crosscheck.trial.judge import places as entries
from crosscheck.trial.judge.places import EntryPlace, NaturalSizes
from crosscheck.trial.judge.questions import AGAIN, StateQuestion, VerificationProblem

MEANINGFUL = 1e-4  # engines further apart, at the end of what numbers can do, judge nobody
COMPARED = ("mass_matrix", "bias", "force", "acceleration")
RUN = "trial-run"
RIGID = ("theta", "theta_dot", "kinetic_energy")
MESH = ("x_sp", "x_pr")
NO_DIAGONAL = "the diagonal is not positive at every state"
Judged = tuple[Finding, list[EntryPlace]]
Check = Callable[..., Judged]  # of About, sizes, and the answers to what is asked


def sizing(
    problem: VerificationProblem, level: str
) -> tuple[StateQuestion, StateQuestion, StateQuestion]:
    """The questions whose answers give the sizes: M, force and acceleration of the reference."""
    ask = partial(problem.ask, problem.reference(level))
    return ask("mass_matrix"), ask("force"), ask("acceleration")


def trusted(
    problem: VerificationProblem, results: Results, level: str
) -> tuple[np.ndarray, np.ndarray | None, np.ndarray | None]:
    """The reference's M, force and acceleration, state by state. Raises Unavailable without M."""
    mass, force, acceleration = sizing(problem, level)
    return results.need(mass), results.settled(force), results.settled(acceleration)


def sizes_in(problem: VerificationProblem, results: Results, level: str) -> NaturalSizes:
    """Natural sizes by the reference's answers. Raises Unavailable."""
    precision = problem.equations.table.precision if problem.equations.table else 0.0
    found = trusted(problem, results, level)
    return entries.sizes_of(problem.frame, problem.states, *found, precision)


def own_comparisons(problem: VerificationProblem) -> Iterator[Comparison]:
    """Engine-free checks of the parts that are there; the reference lends its sizes alone."""
    has, equations = problem.has, problem.equations
    for part in COMPARED:
        if part in has and (part != "acceleration" or equations.acceleration):
            again = _entries(part, partial(_apart, part))
            yield _own(problem, f"repeatable-{part}", again, part, part, f"{part}{AGAIN}")
    if "mass_matrix" in has:
        yield _own(problem, "symmetric", _symmetric, "mass_matrix", "mass_matrix")
        yield _own(problem, "positive-definite", _positive, "mass_matrix", "mass_matrix")
    if "bias" in has:
        quadratic = _entries("bias", _quadratic)
        yield _own(problem, "bias-quadratic", quadratic, "bias", "bias", "other_speeds")
    if {"mass_matrix", "bias"} <= has:
        demanded, terms = _entries("rate_terms", partial(_apart, "rate_terms")), "rate_terms"
        yield _own(problem, "bias-from-inertia", demanded, "mass_matrix", terms, "christoffel")
    if equations.inverse_dynamics is not None:
        whole = _entries("bias", _inverse_dynamics)
        yield _own(problem, "inverse-dynamics", whole, "mass_matrix", "inverse_dynamics")
    if "force" in has and not problem.undriven:
        linear = _entries("force", _by_torques)
        yield _own(problem, "linear-in-torques", linear, "force", "by_torques")
    if equations.acceleration is not None and has >= {*COMPARED}:
        yield _own(problem, "second-law", _entries("force", _second_law), "force", *COMPARED)


def _own(
    problem: VerificationProblem, quantity: str, check: Check, unit_part: str, *parts: str
) -> Comparison:
    """A check of equations against themselves.

    Args:
        problem: The equations.
        quantity: The name of the check.
        check: Judges the answers to ``parts``.
        unit_part: The part whose numbers show the unit of what is judged.
        parts: The questions whose answers are judged.
    """
    questions = tuple(map(problem.yours, parts))
    key = Key("trial-own", problem.case.arm.name, quantity, problem.name)
    metric = f"largest relative deviation of an entry over {problem.count} random states"

    def judged(about: About, results: Results) -> Finding:
        answers = [results.need(question) for question in questions]
        finding, places = check(about, _own_sizes(problem, results, unit_part), *answers)
        return replace(finding, note=finding.note or entries.listed(places, problem.frame.names))

    about = About(key, "1", metric, "first principles")
    right = (problem.ask(problem.reference(level), unit_part) for level in problem.levels)
    sizes = (question for level in problem.levels for question in sizing(problem, level))
    needs = dict.fromkeys((*questions, problem.yours(unit_part), *right, *sizes))
    return Comparison(about, tuple(needs), judged)


def _own_sizes(problem: VerificationProblem, results: Results, unit_part: str) -> NaturalSizes:
    """Natural sizes by the level that is nearest, in the unit of the equations' own numbers.

    What equations owe to themselves they owe in any unit; no number of theirs but that power of ten
    is in a size. Raises Unavailable.
    """
    yours, ratios = results.need(problem.yours(unit_part)), dict[str, float]()
    for level in problem.levels:
        right = results.settled(problem.ask(problem.reference(level), unit_part))
        ratios[level] = 1.0 if right is None else entries.unit_ratio(yours, right)
    nearest = min(problem.levels, key=lambda level: abs(math.log(ratios[level])))
    sizes = sizes_in(problem, results, nearest)
    return sizes.in_unit(entries.power_of_ten(ratios[nearest]))


def _entries(quantity: str, apart_of: Callable[..., np.ndarray]) -> Check:
    """A check of every entry; apart_of: how far it is off, by sizes and answers, over its size."""

    def check(about: About, sizes: NaturalSizes, *answers: np.ndarray) -> Judged:
        apart, tolerance = apart_of(sizes, *answers), sizes.tolerance(quantity)
        beyond = np.argwhere(~(apart <= tolerance))
        wrong = [entries.place_of(quantity, tuple(index)) for index in beyond.tolist()]
        basis = sizes.basis(quantity)
        return checked(about, measured=float(apart.max()), tolerance=tolerance, basis=basis), wrong

    return check


def _apart(quantity: str, sizes: NaturalSizes, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Deviations of two answers: to a question asked twice, or of bias terms and what M demands."""
    return entries.deviations(one, other, sizes.of(quantity))


def _symmetric(about: About, sizes: NaturalSizes, mass: np.ndarray) -> Judged:
    """Check that M (count, n, n) equals its transpose at every state."""
    if not all(map(usable, mass)):
        lowest = np.einsum("kii->ki", mass).min(axis=0)
        bad = np.flatnonzero(~(lowest > 0)).tolist()
        return failed(about, NO_DIAGONAL), [EntryPlace("mass_matrix", i, i) for i in bad]
    apart = entries.deviations(mass, mass.swapaxes(1, 2), sizes.mass)
    tolerance = SYMMETRY + sizes.written("mass_matrix")
    wrong = [EntryPlace("mass_matrix", i, j) for i, j in np.argwhere(apart > tolerance) if i < j]
    basis = "rounding of the entries' natural sizes"
    return checked(about, measured=float(apart.max()), tolerance=tolerance, basis=basis), wrong


def _positive(about: About, sizes: NaturalSizes, mass: np.ndarray) -> Judged:
    """Check that the scaled M (count, n, n) has positive eigenvalues at every state."""
    if not all(map(usable, mass)):
        return failed(about, NO_DIAGONAL), []
    symmetric_part = (mass + mass.swapaxes(1, 2)) / 2
    lowest = [float(np.linalg.eigvalsh(scaled(matrix)).min()) for matrix in symmetric_part]
    state = int(np.argmin(lowest))
    if lowest[state] <= 0:
        note = f"not positive definite at state {state + 1} of {len(mass)}: {lowest[state]:.3g}"
        return failed(about, note), []
    return checked(about, measured=0.0, tolerance=0.0, basis="every eigenvalue is positive"), []


def _quadratic(sizes: NaturalSizes, bias: np.ndarray, at_speeds: np.ndarray) -> np.ndarray:
    """Deviation from h(x, s u) = s^2 h(x, u) for s = -1 and 2, and h(x, 0) = 0, shape (n,).

    bias (count, n); at_speeds (count, speeds + 1, n): h(x, s u) / s^2, then h(x, 0).
    """
    expected = np.repeat(bias[:, None], at_speeds.shape[1], axis=1)
    expected[:, -1] = 0.0
    return (np.abs(at_speeds - expected) / sizes.bias).max(axis=(0, 1))


def _by_torques(sizes: NaturalSizes, answers: np.ndarray) -> np.ndarray:
    """Deviation of forces (n,) from sums of what each torque does, proportional to it.

    answers (count, 2 m + 2, n): at no torque, each alone, twice each alone, all together.
    """
    joints = (answers.shape[1] - 2) // 2
    none, each = answers[:, :1], answers[:, 1 : 1 + joints]
    twice, together = answers[:, 1 + joints : -1], answers[:, -1:]
    doubled = twice - none - 2 * (each - none)
    summed = together - none - (each - none).sum(axis=1, keepdims=True)
    apart: np.ndarray = np.abs(np.concatenate([doubled, summed], axis=1)).max(axis=(0, 1))
    return apart / sizes.force


def _second_law(sizes: NaturalSizes, *answers: np.ndarray) -> np.ndarray:
    """Deviation from M a + h = f, with the acceleration that was handed over beside them, (n,).

    answers: M (count, n, n); bias, force and acceleration (count, n).
    """
    mass, bias, force, acceleration = answers
    left = np.einsum("kij,kj->ki", mass, acceleration) + bias
    return entries.deviations(left, force, sizes.force)


def _inverse_dynamics(sizes: NaturalSizes, answers: np.ndarray) -> np.ndarray:
    """Deviation of inverse dynamics from M a + h, for any a and u together, shape (n,).

    answers (count, 3, n): as handed over; M a + h; a.
    """
    one, other, a = answers.swapaxes(0, 1)
    size = sizes.bias + sizes.mass @ np.abs(a).max(axis=0)
    return entries.deviations(one, other, size)


def own_balances(problem: VerificationProblem) -> Iterator[Comparison]:
    """Checks of power and momentum, for geared equations that have everything.

    There are none if the map is a function: it need not reach every pose that these checks draw.
    """
    rigid = problem.gearing == "rigid"
    if rigid or problem.frame.matrix is None or not problem.has >= {*COMPARED}:
        return
    sampled = SampledModel(
        problem.case.arm.name, problem.name, problem.case, problem.count, problem.seed
    )
    for found in balances(sampled):
        judged = partial(_carried, problem, found)
        yield Comparison(found.about, (*found.needs, *sizing(problem, "")), judged)


def _carried(
    problem: VerificationProblem, balance: Comparison, about: About, results: Results
) -> Finding:
    """The finding of a balance, its tolerance widened by the rounding of the coordinates' map."""
    found, sizes = balance.judge(about, results), sizes_in(problem, results, "")
    if found.measured is None or found.tolerance is None:
        return found
    looser = sizes.tolerance("acceleration") / LOOSEST
    return checked(
        about,
        measured=found.measured,
        tolerance=found.tolerance * looser,
        basis=f"{found.basis}; times {looser:.3g}: {sizes.basis('acceleration')}",
        relative=found.relative,
    )


def engine_comparisons(
    problem: VerificationProblem, level: str, *, binding: bool
) -> Iterator[Comparison]:
    """Compare every part with every engine.

    binding: whether they must agree; if not, as at a level that is not claimed, they are measured.
    """
    for part in COMPARED:
        for engine in problem.engines(level) if part in problem.has else ():
            yield _against(problem, engine, part, level, binding)


def _against(
    problem: VerificationProblem, engine: str, part: str, level: str, binding: bool
) -> Comparison:
    yours, theirs = problem.yours(part), problem.ask(engine, part)
    reference = problem.ask(problem.reference(level), part)
    key = Key("trial-states", problem.case.arm.name, part, problem.name, engine)
    metric = f"largest relative difference of an entry over {problem.count} random states"

    def judged(about: About, results: Results) -> Finding:
        one, other = results.need(yours), results.need(theirs)
        sizes = sizes_in(problem, results, level)
        measured = float(entries.deviations(one, other, sizes.of(part)).max())
        if not binding:
            return measured_only(about, measured=measured)
        wrong = [each.place for each in entries.wrong_entries(part, one, other, sizes)]
        among = float(entries.deviations(results.need(reference), other, sizes.of(part)).max())
        return checked(
            about,
            measured=measured,
            tolerance=sizes.tolerance(part) + among,
            basis=f"{sizes.basis(part)}; engines among themselves {among:.2g}",
            resolved=among <= MEANINGFUL,
            relative=measured,
            note=entries.listed(wrong, problem.frame.names),
        )

    needs = dict.fromkeys((yours, theirs, reference, *sizing(problem, level)))
    return Comparison(About(key, "1", metric), tuple(needs), judged)


def run_comparisons(
    problem: VerificationProblem, scenario: Scenario, level: str
) -> Iterator[Comparison]:
    """Compare a scenario's run by the equations with each engine that takes the same steps."""
    engines = same_integrator()
    if level:
        engines = tuple(name for name in problem.engines(level) if MODELS[name].order == 4)
    meshes = () if level or not problem.frame.layout.meshing else MESH
    for engine in engines:
        for quantity in (*RIGID, *meshes):
            yield _same_steps(problem, scenario, engine, quantity)


def _same_steps(
    problem: VerificationProblem, scenario: Scenario, engine: str, quantity: str
) -> Comparison:
    case, name = problem.case._replace(scenario=scenario), scenario.name
    yours = Simulation(RunKey(name, problem.name), case)
    theirs = Simulation(RunKey(name, engine), case)
    repeated = Simulation(RunKey(name, engine, "nudged"), nudged(case))

    def judged(about: About, one: Any, other: Any, moved: Any) -> Finding:
        widest = meaningful(quantity, case.arm, scenario, size(other, quantity))
        return same_step(about, one, other, Pair(other, moved), widest)

    key = Key(RUN, name, quantity, problem.name, engine)
    about = About(key, UNITS[quantity], "largest absolute difference")
    return answered(about, (yours, theirs, repeated), judged)
