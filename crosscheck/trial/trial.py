"""A trial from end to end: supply, ask, compare, find the wrong entries, explain them."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.findings import Agreement
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError, Unfinished
from crosscheck.models.experiment.scenario import (
    ConstantDrive,
    PdDrive,
    Scenario,
    SinusoidDrive,
    expand_to_joints,
)
from crosscheck.models.loading import Case
from crosscheck.planning import comparison
from crosscheck.planning.comparison import Comparison, ModelTask, Results
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.provenance import record_provenance
from crosscheck.registry import find_distinct_levels, group_equal_levels, packages, register
from crosscheck.run import CrossCheck, cases_by_run, run_tasks, runs_by_key
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.progress_update import ProgressCallback, ignore_progress
from crosscheck.runner.supervision import track_foreign_code
from crosscheck.runner.workers import Workers
from crosscheck.trial.changes.arms.answer_keys import make_arm_answer_keys
from crosscheck.trial.changes.arms.arm_numbers import find_negligible_inertias, replace_numbers
from crosscheck.trial.changes.arms.causes import explain_entries, explain_linear_rates
from crosscheck.trial.changes.arms.comparison import (
    compare_entries,
    list_entry_quantities,
    list_entry_questions,
)
from crosscheck.trial.changes.arms.dependence import IgnoredNumber, Perform
from crosscheck.trial.changes.arms.diagnosis import Diagnosis, build_probe_problems, diagnose
from crosscheck.trial.changes.arms.other_coordinates import find_readings
from crosscheck.trial.changes.arms.segments import build_reference_terms
from crosscheck.trial.changes.arms.waves import minimum_state_count
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.coordinates.readings import Reading
from crosscheck.trial.input.arrays import is_single_precision
from crosscheck.trial.input.supplied import SuppliedEquations, bind_equations
from crosscheck.trial.judge import suite
from crosscheck.trial.judge.checks import COMPARED, SelfCheck, find_idle_motors, judge_answers
from crosscheck.trial.judge.entries import (
    EntryMismatch,
    LevelDistance,
    deviations,
    measure_distance,
    sort_distances,
)
from crosscheck.trial.judge.questions import (
    QUESTIONS,
    VerificationProblem,
    make_experiment,
    run_first_calls,
    skip_dependent_tasks,
)
from crosscheck.trial.judge.unit_mistakes import UnitMistake, find_unit_mistakes
from crosscheck.trial.model import make_registry_entry, select_switches
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.result import TrialResult
from crosscheck.trial.source.code import find_code
from crosscheck.trial.source.search import find_source_answer
from crosscheck.trial.source.source_edit import SourceAnswer

if TYPE_CHECKING:
    from crosscheck.report.trials.answer import TrialAnswer

JUDGING_S = 60.0  # rough cost
RUNNABLE = {"mass_matrix", "bias", "force"}
# Enough states to distinguish all the waves and signals that an entry may contain.
STATES, QUICK_STATES = 300, 150
LEAST_STATES = 20
_trial_lock = threading.Lock()
MOST_BYTES = 300_000_000  # memory for a bias's terms at all states, of which a trial holds several


@dataclass(frozen=True, repr=False)
class Trial(TrialResult):
    """Supplied equations, judged.

    Args:
        problem: The equations, and what they are compared with.
        cross_check: All findings, as a baseline records them.
        level: The rigid level that the equations are, or are closest to; '' of geared ones.
        distances: How far the equations are from each rigid level, the nearest first.
        relative_errors: By part, how far each entry is from the reference's, relative to its size:
            M (n, n), terms of the bias (n, n, n), force (n,).
        allowed: By part, what of the relative error is no error.
        wrong_entries: The entries that are not right.
        hidden_entries: Entries that are right here, and not on the arms of ``probes``.
        ignored_numbers: Numbers of the arm's file that the equations do not follow, which the arms
            of ``probes`` keep.
        probes: Names of other arms that were asked too.
        missing: Parts that were not supplied.
        unit_mistakes: Parts that become right after a change of unit or of element order.
        traces: Tracebacks, by part, of parts that raised.
        self_checks: What the equations owe to themselves, judged.
        left_out: Names of all numbers that the equations do not follow, errors or not.
        idle_joints: Joints, from 0, whose motor's torque changes no force of the equations.
        readings: Other coordinates in which all is right; then no other reason is looked for.
        point_masses: Inertias of links that the equations leave out and that are next to nothing:
            judged as 0.
        is_single_precision: Whether a part's answers have no more digits than that.
        source_answer: What must change in the user's source, where a small edit mends it.
    """

    problem: VerificationProblem
    cross_check: CrossCheck
    level: str
    distances: tuple[LevelDistance, ...]
    relative_errors: dict[str, np.ndarray]
    allowed: dict[str, float]
    wrong_entries: tuple[EntryMismatch, ...]
    hidden_entries: tuple[EntryMismatch, ...]
    ignored_numbers: tuple[IgnoredNumber, ...]
    probes: tuple[str, ...]
    missing: tuple[str, ...]
    unit_mistakes: tuple[UnitMistake, ...]
    traces: dict[str, str]
    left_out: tuple[str, ...]
    self_checks: tuple[SelfCheck, ...]
    idle_joints: tuple[int, ...] = ()
    readings: tuple[Reading, ...] = ()
    point_masses: tuple[str, ...] = ()
    is_single_precision: bool = False
    source_answer: SourceAnswer | None = None

    @property
    def agreement(self) -> Agreement:
        """All checks and measurements of the trial."""
        return self.cross_check.agreement

    @property
    def answer(self) -> TrialAnswer:
        """What the trial has to say, the most important first."""
        from crosscheck.report.trials.trial import answer_arm_trial

        return answer_arm_trial(self)


def run_arm_trial(request: TrialRequest, progress: ProgressCallback = ignore_progress) -> Trial:
    """Judge supplied equations; of several threads one after the other, for models have names.

    Raises InputError for what cannot be tried at all, and Unfinished where the models that they are
    compared with do not answer.
    """
    with _trial_lock:
        trial = _run_trial(request, progress)
        points = find_negligible_inertias(request.mechanism, trial.left_out)
        if points:
            arm = replace_numbers(request.mechanism, dict.fromkeys(points, 0.0))
            trial = _run_trial(replace(request, mechanism=arm), progress)
        answer = _find_source_answer(trial, progress)
        return replace(trial, point_masses=points, source_answer=answer)


def _find_source_answer(trial: Trial, progress: ProgressCallback) -> SourceAnswer | None:
    """Change of the source that makes wrong equations right, in any coordinates."""
    is_wrong = trial.exit_code and not trial.readings
    code = find_code(trial.problem.equations) if is_wrong else None
    if code is None:
        return None
    given = trial.problem, trial.level, trial.ignored_numbers
    return find_source_answer(code, partial(make_arm_answer_keys, *given), progress)


def _run_trial(request: TrialRequest, progress: ProgressCallback) -> Trial:
    with track_foreign_code(request.name):
        problem = build_problem(request)
        probes = build_probe_problems(problem)
    entry = make_registry_entry(problem.name, problem.equations, problem.has)
    with register(problem.name, entry), Workers(request.jobs) as workers:
        failed_parts = run_first_calls(problem, workers, progress)

        def perform(tasks: Sequence[ModelTask]) -> Results:
            """Ask what can be asked; a function that does not come back is called no more."""
            without = skip_dependent_tasks(problem, tasks, failed_parts)
            new_results = run_tasks(
                workers, [task for task in tasks if task not in without], progress
            )
            lost_tasks = {task.key: failure for task, failure in without.items()}
            return Results({**new_results.outcomes, **lost_tasks})

        results = perform(list_tasks(problem, probes, request))
        try:
            with track_foreign_code(request.name, JUDGING_S):
                return _judge_trial(problem, probes, request, results, perform)
        except comparison.MissingResult as error:
            raise Unfinished(f"{problem.name} cannot be judged: {error}") from None


def list_tasks(
    problem: VerificationProblem, probes: Sequence[VerificationProblem], request: TrialRequest
) -> list[ModelTask]:
    """All tasks of a trial: of the equations, and of the models that they are compared with."""
    planned = list(_plan_comparisons(problem, request, problem.levels))
    questions = [*suite.list_questions(problem), *_entry_tasks((problem, *probes))]
    return list(dict.fromkeys([*comparison.collect_tasks(planned), *questions]))


def _require_runnable(request: TrialRequest, bound: SuppliedEquations) -> None:
    """Raise InputError for a scenario that the equations cannot be run in."""
    missing = ", ".join(sorted(RUNNABLE - bound.has))
    for scenario in request.scenarios:
        if missing:
            reason = f"needs {missing}, which the equations have not"
            raise InputError("--scenario", "", scenario.name, reason)
        idle = sorted(set(range(len(bound.arm.joints))) - set(bound.motors))
        driven = [str(joint + 1) for joint in idle if _is_driven(scenario, joint, bound.arm)]
        if driven:
            which = "joint" if len(driven) == 1 else "joints"
            reason = f"drives {which} {', '.join(driven)}; the equations take no torque there"
            raise InputError("--scenario", "", scenario.name, reason)


def _is_driven(scenario: Scenario, joint: int, arm: Arm) -> bool:
    """Whether a scenario has a torque on a joint at any time."""
    drive, joints = scenario.drive, len(arm.joints)
    if isinstance(drive, ConstantDrive):
        return bool(expand_to_joints(drive.torque_N_m, joints)[joint])
    if isinstance(drive, PdDrive):
        gains = (drive.proportional_N_m_per_rad, drive.derivative_N_m_s_per_rad)
        return any(expand_to_joints(gain, joints)[joint] for gain in gains)
    if isinstance(drive, SinusoidDrive):
        return bool(expand_to_joints(drive.amplitude_N_m, joints)[joint])
    return any(drive.torque_N_m[joint])


def _entry_tasks(problems: Sequence[VerificationProblem]) -> Iterator[ModelTask]:
    for each in problems:
        yield from list_entry_questions(each, each.levels, list_entry_quantities(each))


def build_problem(request: TrialRequest) -> VerificationProblem:
    """The supplied equations, with coordinates and states already made. Raises InputError."""
    make_cross_check_request(request)  # refuses scenarios that cannot stand side by side
    arm: Arm = request.mechanism
    laws = select_switches(request.equations, arm, request.switches)
    count = QUICK_STATES if request.quick else STATES
    scenario = make_experiment(arm, range(len(arm.joints)))
    equations = request.equations.adapt_to_arm(arm, scenario)
    bound = bind_equations(equations, arm, build_frame(equations.coordinates, arm))
    if len(bound.motors) < len(arm.joints):
        scenario = make_experiment(arm, bound.motors)
        equations = request.equations.adapt_to_arm(arm, scenario)
    _require_runnable(request, bound)
    case = Case(arm, scenario, laws)
    problem = VerificationProblem(
        request.name, equations, bound.has, case, count, request.seed, bound.motors
    )
    if problem.frame.matrix is not None:
        terms = build_reference_terms(
            problem.frame, arm, laws, problem.levels[-1], has_gravity=problem.has_gravity
        )
        count = max(count, minimum_state_count(terms))
    affordable = MOST_BYTES // (8 * len(problem.frame.names) ** 3)
    problem = replace(problem, count=min(count, max(affordable, LEAST_STATES)))
    _ = problem.states  # made now, so that what is wrong with the coordinates is said first
    return problem


def _plan_comparisons(
    problem: VerificationProblem, request: TrialRequest, levels: Sequence[str]
) -> Iterator[Comparison]:
    """The comparisons of runs at levels, and the balances."""
    for level in levels:
        for scenario in request.scenarios:
            yield from suite.plan_run_comparisons(problem, scenario, level)
    yield from suite.plan_balance_checks(problem)


def _judge_trial(
    problem: VerificationProblem,
    probes: Sequence[VerificationProblem],
    request: TrialRequest,
    results: Results,
    perform: Perform,
) -> Trial:
    distances = _measure_levels(problem, results)
    nearest = distances[0].level if distances else ""
    level = _select_equal_level(problem, probes, nearest, results)
    here = compare_entries(problem, level, list_entry_quantities(problem), results)
    reading_level, readings = "", list[Reading]()
    wrong_parts = {wrong.place.part for wrong in here.wrong_entries}
    answers = suite.collect_answers(problem, results)
    if "mass_matrix" in wrong_parts or (wrong_parts and "mass_matrix" not in problem.has):
        reading_level, readings = find_readings(problem, answers.values)
    level = reading_level or level
    if wrong_parts == {"acceleration"} and not readings:
        level = _select_explained_level(problem, probes, level, results)
    comparisons = list(_plan_comparisons(problem, request, [level]))
    self_checks = tuple(judge_answers(answers))
    check, cases = make_cross_check_request(request), cases_by_run(comparisons)
    settings = check.arm, check.seed, check.quick, check.scenarios, check.chosen
    record = record_provenance(*settings, packages=packages(), model=check.model)
    findings = [check.finding for check in self_checks]
    findings += suite.judge_engines(problem, answers, results, level)
    findings += comparison.judge_comparisons(comparisons, results)
    agreement = Agreement(findings, record)
    runs = {key: run for key, run in runs_by_key(results).items() if key in cases}
    here, *there = (
        compare_entries(each, level, list_entry_quantities(each), results)
        for each in (problem, *(() if readings else probes))
    )
    if readings:
        diagnosis = Diagnosis(list(here.wrong_entries), [], [])
    else:
        diagnosis = diagnose(here, there, perform)
        diagnosis.wrong_entries.extend(explain_linear_rates(here))
    return Trial(
        problem=problem,
        cross_check=CrossCheck(check, agreement, cases, runs),
        level=level,
        distances=tuple(distances),
        relative_errors=here.relative_errors,
        allowed={quantity: here.sizes.tolerance(quantity) for quantity in here.relative_errors},
        wrong_entries=tuple(wrong for wrong in diagnosis.wrong_entries if not wrong.shown_on),
        hidden_entries=tuple(wrong for wrong in diagnosis.wrong_entries if wrong.shown_on),
        ignored_numbers=tuple(each for each in diagnosis.ignored_numbers if each.parts),
        probes=tuple(probe.case.arm.name for probe in probes),
        missing=tuple(part for part in COMPARED if part in suite.WHOLE - problem.has),
        unit_mistakes=find_unit_mistakes(
            here.user_values, here.reference_values, problem.equations.table
        ),
        traces=_traces(problem, results),
        left_out=tuple(
            each.name for each in (*diagnosis.ignored_numbers, *diagnosis.uncertain) if each.parts
        ),
        idle_joints=find_idle_motors(answers, problem.motors),
        self_checks=self_checks,
        readings=tuple(readings),
        is_single_precision=any(map(is_single_precision, answers.values.values())),
    )


def make_cross_check_request(request: TrialRequest) -> CrossCheckRequest:
    """Request for the cross-check behind a trial, with the laws that the equations follow."""
    laws = select_switches(request.equations, request.mechanism, request.switches)
    return CrossCheckRequest(
        request.mechanism, request.quick, request.seed, request.scenarios, laws, request.name
    )


def _measure_levels(problem: VerificationProblem, results: Results) -> list[LevelDistance]:
    """How far the equations are from each rigid level, the nearest first."""
    arm, distances = problem.case.arm, []
    if problem.gearing != "rigid":
        return []
    distinct = [level for level in find_distinct_levels(arm) if level in problem.levels]
    sizes = suite.compute_natural_sizes(problem, results, problem.levels[-1])  # the same for all
    for level in distinct or problem.levels:
        compared = compare_entries(problem, level, list_entry_quantities(problem), results)
        places = {  # two of M that mirror each other are one
            (place.part, place.rates, frozenset((place.row, place.column)))
            for place in (each.place for each in compared.wrong_entries)
        }
        right, errors = compared.reference_values, []
        for part, values in compared.user_values.items():
            errors.append(deviations(values, right[part], sizes.entry_sizes(part)))
        distances.append(measure_distance(level, len(places), errors))
    return sort_distances(distances)


def _select_equal_level(
    problem: VerificationProblem,
    probes: Sequence[VerificationProblem],
    level: str,
    results: Results,
) -> str:
    """Pick, among levels that are equal on the arm, as without motors, that of the other arms.

    There it is the one from which the fewest entries differ; of as many the given one.
    """
    groups = group_equal_levels(problem.case.arm)
    equal = [
        each
        for group in groups
        if level in group
        for each in (level, *group)
        if each in problem.levels
    ]
    if len(equal) < 2:
        return level
    quantities = list_entry_quantities(problem)

    def count_wrong_entries(each: str) -> int:
        comparisons = (compare_entries(probe, each, quantities, results) for probe in probes)
        return sum(len(list(comparison.wrong_entries)) for comparison in comparisons)

    return min(equal, key=count_wrong_entries)


def _select_explained_level(
    problem: VerificationProblem,
    probes: Sequence[VerificationProblem],
    level: str,
    results: Results,
) -> str:
    """The first level beside which errors explain wrong accelerations; the given one before others.

    Errors in M may bring accelerations nearer to a level that is not theirs.
    """
    for each in dict.fromkeys((level, *problem.levels)):
        here, *there = (
            compare_entries(asked, each, ["acceleration"], results) for asked in (problem, *probes)
        )
        if here.terms is None:
            break
        wrong = [w for w in explain_entries(here, there) if not w.shown_on]
        if wrong and all(w.explanation for w in wrong):
            return each
    return level


def _traces(problem: VerificationProblem, results: Results) -> dict[str, str]:
    """Tracebacks of the parts that raised, each once."""
    traces: dict[str, str] = {}
    for quantity in QUESTIONS:
        outcome = results.outcomes.get(problem.ask_equations(quantity))
        trace = outcome.trace if isinstance(outcome, Failure) else ""
        if trace and trace not in traces.values():
            traces[quantity] = trace
    return traces
