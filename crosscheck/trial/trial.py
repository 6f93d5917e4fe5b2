"""A trial from end to end: hand over, ask, compare, find the wrong entries, explain them."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from crosscheck.findings import Agreement
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError, Unfinished
from crosscheck.models.experiment.scenario import ConstantDrive, Scenario, Switches
from crosscheck.models.loading import Case
from crosscheck.planning import comparison
from crosscheck.planning.comparison import Comparison, ModelTask, Results
from crosscheck.planning.plan import Wanted
from crosscheck.provenance import provenance
from crosscheck.registry import packages, register
from crosscheck.run import CrossCheck, cases_of, performed, runs_of
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.supervision import overseen
from crosscheck.runner.underway import Told, unsaid
from crosscheck.runner.workers import Workers
from crosscheck.trial.coordinates.frame import frame_of
from crosscheck.trial.diagnose.arm_numbers import negligible_inertias, with_numbers
from crosscheck.trial.diagnose.dependence import Perform, Unfollowed
from crosscheck.trial.diagnose.diagnosis import diagnosed, probes_of
from crosscheck.trial.diagnose.reasons import compared, entry_quantities, entry_questions
from crosscheck.trial.diagnose.reference_terms import reference_terms_of
from crosscheck.trial.diagnose.waves import states_wanted
from crosscheck.trial.input.calls import SuppliedEquations, supplied
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.judge import suite
from crosscheck.trial.judge.misread import Misread, misread
from crosscheck.trial.judge.places import Wrong, deviations
from crosscheck.trial.judge.questions import (
    QUESTIONS,
    VerificationProblem,
    experiment,
    first_calls,
    spared,
)
from crosscheck.trial.model import entry_for, switches_of

BRINGS = {
    "links": "links and payload",
    "carriers": "masses at the joints: rings, carriers, planets, suns, motors",
    "armature": "the gears' reflected inertia, on the diagonal",
    "coupled": "the gears' spin, coupled to the turning of their base",
}
JUDGING_S = 60.0  # rough cost
RUNNABLE = {"mass_matrix", "bias", "force"}
# Enough to tell all the waves and signals apart that an entry may hold.
STATES, QUICK_STATES = 300, 150
LEAST_STATES = 20
_one_at_a_time = threading.Lock()
MOST_BYTES = 300_000_000  # of the terms of a bias at all states, of which a trial holds several


@dataclass(frozen=True)
class Asked:
    """What a user asks a trial of equations on an arm to do.

    scenarios: to be run, none for a trial by states alone; chosen: laws, None for the usual.
    """

    name: str
    equations: Equations
    arm: Arm
    scenarios: tuple[Scenario, ...] = ()
    chosen: Switches | None = None
    quick: bool = False
    seed: int = 0


@dataclass(frozen=True)
class Rung:
    """A rigid level beside a user's equations: how many entries of M differ, and by how much.

    largest, mean: of the differences of all entries, relative to their sizes.
    """

    level: str
    entries: int
    largest: float
    mean: float

    @property
    def brings(self) -> str:
        """What of the arm the level has beyond the level below, in words."""
        return BRINGS[self.level]


@dataclass(frozen=True)
class Trial:
    """Supplied equations, judged.

    cross_check: what was found, as a baseline records it. level: the rigid level that they are,
    or are closest to; '' of geared ones. apart: by part, how far each entry is from the
    reference's, relative to its size: M (n, n), terms of the bias (n, n, n), force (n,); allowed:
    by part, what of it is no error. wrong: the entries that are not right. hidden: entries that
    are right here, and not on ``probes``, other arms that were asked too. unfollowed: numbers of
    the arm's file that the equations do not follow, which these arms keep. left_out: names of all
    such numbers, errors or not. point_masses: inertias of links that the equations leave out and
    that are next to nothing: judged as 0. missing: parts that were not supplied. misread: parts
    that units or the order of numbers explain. traces: of parts that raised.
    """

    problem: VerificationProblem
    cross_check: CrossCheck
    level: str
    rungs: tuple[Rung, ...]
    apart: dict[str, np.ndarray]
    allowed: dict[str, float]
    wrong: tuple[Wrong, ...]
    hidden: tuple[Wrong, ...]
    unfollowed: tuple[Unfollowed, ...]
    probes: tuple[str, ...]
    missing: tuple[str, ...]
    misread: tuple[Misread, ...]
    traces: dict[str, str]
    left_out: tuple[str, ...]
    point_masses: tuple[str, ...] = ()

    @property
    def agreement(self) -> Agreement:
        """All checks and measurements of the trial."""
        return self.cross_check.agreement

    @property
    def exit_code(self) -> int:
        """The exit code of the agreement."""
        return self.agreement.exit_code


def tried(asked: Asked, *, jobs: int = 1, told: Told = unsaid) -> Trial:
    """Put equations on trial; of several threads one after the other, for models have names.

    Raises InputError for what cannot be tried at all, and Unfinished where the models that they are
    held against do not answer.
    """
    with _one_at_a_time:
        trial = _tried(asked, jobs, told)
        points = negligible_inertias(asked.arm, trial.left_out)
        if not points:
            return trial
        arm = with_numbers(asked.arm, dict.fromkeys(points, 0.0))
        return replace(_tried(replace(asked, arm=arm), jobs, told), point_masses=points)


def _tried(asked: Asked, jobs: int, told: Told) -> Trial:
    with overseen(asked.name):
        problem = problem_of(asked)
        probes = probes_of(problem)
    entry = entry_for(problem.name, problem.equations, problem.has)
    with register(problem.name, entry), Workers(jobs) as workers:
        lost = first_calls(problem, workers, told)

        def perform(tasks: Sequence[ModelTask]) -> Results:
            """Ask what can be asked; a function that does not come back is called no more."""
            without = spared(problem, tasks, lost)
            found = performed(workers, [task for task in tasks if task not in without], told)
            lost_tasks = {task.key: failure for task, failure in without.items()}
            return Results({**found.outcomes, **lost_tasks})

        results = perform(tasks_in(problem, probes, asked))
        try:
            with overseen(asked.name, JUDGING_S):
                return _judged(problem, probes, asked, results, perform)
        except comparison.Unavailable as error:
            raise Unfinished(f"{problem.name} cannot be judged: {error}") from None


def tasks_in(
    problem: VerificationProblem, probes: Sequence[VerificationProblem], asked: Asked
) -> list[ModelTask]:
    """All tasks of a trial: of the equations, and of the models that they are compared with."""
    planned = list(_planned(problem, asked))
    return list(dict.fromkeys([*comparison.tasks_of(planned), *_by_entry((problem, *probes))]))


def _require_runnable(asked: Asked, bound: SuppliedEquations) -> None:
    """Raise InputError for a scenario that the equations cannot be run in."""
    missing = ", ".join(sorted(RUNNABLE - bound.has))
    for scenario in asked.scenarios:
        if missing:
            reason = f"needs {missing}, which the equations have not"
            raise InputError("--scenario", "", scenario.name, reason)
        if bound.is_undriven and not _is_undriven(scenario):
            reason = "drives the joints; the equations take no torque"
            raise InputError("--scenario", "", scenario.name, reason)


def _is_undriven(scenario: Scenario) -> bool:
    """Whether a scenario has no torque at any time."""
    drive = scenario.drive
    return isinstance(drive, ConstantDrive) and not np.any(drive.torque_N_m)


def _by_entry(problems: Sequence[VerificationProblem]) -> Iterator[ModelTask]:
    for each in problems:
        yield from entry_questions(each, each.levels, entry_quantities(each))


def problem_of(asked: Asked) -> VerificationProblem:
    """What is on trial, its coordinates and states already made. Raises InputError."""
    wanted_of(asked)  # refuses scenarios that cannot stand side by side
    laws = switches_of(asked.equations, asked.arm, asked.chosen)
    count = QUICK_STATES if asked.quick else STATES
    scenario = experiment(asked.arm, undriven=False)
    own = asked.equations.on(asked.arm, scenario)
    bound = supplied(own, asked.arm, frame_of(own.coordinates, asked.arm))
    if bound.is_undriven:
        scenario = experiment(asked.arm, undriven=True)
        own = asked.equations.on(asked.arm, scenario)
    _require_runnable(asked, bound)
    case = Case(asked.arm, scenario, laws)
    problem = VerificationProblem(
        asked.name, own, bound.has, case, count, asked.seed, bound.is_undriven
    )
    if problem.frame.matrix is not None:
        terms = reference_terms_of(problem.frame, asked.arm, laws, problem.levels[-1])
        count = max(count, states_wanted(terms))
    affordable = MOST_BYTES // (8 * len(problem.frame.names) ** 3)
    problem = replace(problem, count=min(count, max(affordable, LEAST_STATES)))
    _ = problem.states  # made now, so that what is wrong with the coordinates is said first
    return problem


def _planned(
    problem: VerificationProblem,
    asked: Asked,
    level: str | None = None,
    results: Results | None = None,
) -> Iterator[Comparison]:
    """Every comparison; binding are those of a level, or of all levels where none is chosen.

    results: if they are given, an unclaimed level has only comparisons whose answers are there, for
    a part that failed fails once, at the claimed level.
    """
    yield from suite.own_comparisons(problem)
    for each in problem.levels:
        binding = level is None or each == level
        for planned in suite.engine_comparisons(problem, each, binding=binding):
            own = (task for task in planned.needs if task.model == problem.name)
            if binding or results is None or all(results.found(t) is not None for t in own):
                yield planned
        for scenario in asked.scenarios if binding else ():
            yield from suite.run_comparisons(problem, scenario, each)
    yield from suite.own_balances(problem)


def _judged(
    problem: VerificationProblem,
    probes: Sequence[VerificationProblem],
    asked: Asked,
    results: Results,
    perform: Perform,
) -> Trial:
    level, rungs = _level(problem, results)
    comparisons = list(_planned(problem, asked, level, results))
    wanted, cases = wanted_of(asked), cases_of(comparisons)
    settings = wanted.arm, wanted.seed, wanted.quick, wanted.scenarios, wanted.chosen
    record = provenance(*settings, packages=packages(), model=wanted.model)
    agreement = Agreement(list(comparison.findings_of(comparisons, results)), record)
    runs = {key: run for key, run in runs_of(results).items() if key in cases}
    here, *there = (
        compared(each, level, entry_quantities(each), results) for each in (problem, *probes)
    )
    diagnosis = diagnosed(here, there, perform)
    return Trial(
        problem=problem,
        cross_check=CrossCheck(wanted, agreement, cases, runs),
        level=level,
        rungs=tuple(rungs),
        apart=here.apart,
        allowed={quantity: here.sizes.tolerance(quantity) for quantity in here.apart},
        wrong=tuple(wrong for wrong in diagnosis.wrong if not wrong.shown_on),
        hidden=tuple(wrong for wrong in diagnosis.wrong if wrong.shown_on),
        unfollowed=tuple(each for each in diagnosis.unfollowed if each.parts),
        probes=tuple(probe.case.arm.name for probe in probes),
        missing=tuple(part for part in suite.COMPARED if part not in problem.has),
        misread=misread(here.yours, here.right, problem.equations.table),
        traces=_traces(problem, results),
        left_out=tuple(
            each.name for each in (*diagnosis.unfollowed, *diagnosis.uncertain) if each.parts
        ),
    )


def wanted_of(asked: Asked) -> Wanted:
    """What a cross-check would be asked for; its laws are those that the equations follow."""
    laws = switches_of(asked.equations, asked.arm, asked.chosen)
    return Wanted(asked.arm, asked.quick, asked.seed, asked.scenarios, laws, asked.name)


def _level(problem: VerificationProblem, results: Results) -> tuple[str, list[Rung]]:
    """The rigid level from whose M the fewest entries differ, and how far all levels differ.

    Of several the one that is least apart; without a usable mass matrix the one that the other
    parts are least apart from.
    """
    if problem.gearing != "rigid":
        return "", []
    yours = results.found(problem.yours("mass_matrix")) if "mass_matrix" in problem.has else None
    asked = [problem.ask(problem.reference(level), "mass_matrix") for level in problem.levels]
    masses = [results.need(question) for question in asked]
    if yours is None:
        return min(problem.levels, key=partial(_farthest, problem, results)), []
    sizes, rungs = suite.sizes_in(problem, results, problem.levels[-1]), []
    for level, mass in zip(problem.levels, masses, strict=True):
        found = deviations(yours, mass, sizes.mass)
        count = int((~(found <= sizes.tolerance("mass_matrix"))).sum())
        rungs.append(Rung(level, count, float(found.max()), float(found.mean())))
    return min(rungs, key=lambda rung: (rung.entries, rung.mean)).level, rungs


def _farthest(problem: VerificationProblem, results: Results, level: str) -> float:
    """Largest difference of the parts that answer from a level's, relative to their sizes."""
    sizes, found = suite.sizes_in(problem, results, level), [0.0]
    for part in suite.COMPARED:
        own = results.found(problem.yours(part)) if part in problem.has else None
        if own is not None:
            right = results.need(problem.ask(problem.reference(level), part))
            found.append(float(deviations(own, right, sizes.of(part)).max()))
    return max(found)


def _traces(problem: VerificationProblem, results: Results) -> dict[str, str]:
    """Tracebacks of the parts that raised, each once."""
    found: dict[str, str] = {}
    for quantity in QUESTIONS:
        outcome = results.outcomes.get(problem.yours(quantity))
        trace = outcome.trace if isinstance(outcome, Failure) else ""
        if trace and trace not in found.values():
            found[quantity] = trace
    return found
