"""An arm's equations in a trial: asked in workers, beside the models of each level."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import numpy as np

from crosscheck.checks.answers import BadAnswer
from crosscheck.findings import Finding
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError, Unfinished
from crosscheck.models.experiment.scenario import Scenario, Switches, expand_to_joints
from crosscheck.models.loading import Case
from crosscheck.planning import comparison
from crosscheck.planning.comparison import Comparison, ModelTask, Results
from crosscheck.registry import find_distinct_levels, group_equal_levels, register
from crosscheck.run import cases_by_run, run_tasks, runs_by_key
from crosscheck.runner.outcomes import SelfKeyedTask, return_failures
from crosscheck.runner.progress_update import ProgressCallback
from crosscheck.runner.supervision import track_foreign_code
from crosscheck.runner.workers import Workers
from crosscheck.trial.arms import suite
from crosscheck.trial.arms.answer_keys import make_arm_answer_keys
from crosscheck.trial.arms.model import make_registry_entry, select_switches
from crosscheck.trial.arms.questions import (
    VerificationProblem,
    ask_functions,
    make_experiment,
    skip_dependent_tasks,
)
from crosscheck.trial.changes.arms.arm_numbers import (
    find_negligible_inertias,
    get_number,
    list_number_names,
    replace_numbers,
)
from crosscheck.trial.changes.arms.causes import Diagnosis, build_probe_problems, diagnose
from crosscheck.trial.changes.arms.comparison import (
    EntryComparison,
    compare_entries,
    list_entry_questions,
)
from crosscheck.trial.changes.arms.dependence import Dependence, Perform
from crosscheck.trial.changes.arms.other_coordinates import find_readings, is_nearer_absolute
from crosscheck.trial.changes.arms.segments import build_reference_terms
from crosscheck.trial.changes.arms.steps import LevelChanges, find_changes
from crosscheck.trial.changes.arms.term_words import (
    describe_entries,
    describe_point_masses,
    describe_unfollowed,
    name_entry,
)
from crosscheck.trial.changes.arms.waves import minimum_state_count
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.coordinates.readings import Reading
from crosscheck.trial.input.calls import describe_failure
from crosscheck.trial.input.equations import SINGLE, Equations, PartReading
from crosscheck.trial.input.source_lines import has_literal
from crosscheck.trial.input.supplied import (
    FRICTION,
    PARTS_OF_MOTION,
    SuppliedEquations,
    bind_equations,
    find_part_reading,
)
from crosscheck.trial.judge.checks import SECOND_LAW, WHOLE, AnswerSet
from crosscheck.trial.judge.entries import (
    ALONE,
    LONE,
    EntryMismatch,
    LevelDistance,
    deviations,
    find_wrong_entries,
    measure_distance,
    sort_distances,
)
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.result import Trial, TrialDiagnosis
from crosscheck.trial.trial import RunTrial, TrialSubject, make_cross_check_request

JUDGING_S = 60.0  # rough cost
RUNNABLE = {"mass_matrix", "bias", "force"}
# Enough states to distinguish all the waves and signals that an entry may contain.
STATES, QUICK_STATES = 300, 150
LEAST_STATES = 20
MOST_BYTES = 300_000_000  # memory for a bias's terms at all states, of which a trial holds several


@dataclass(frozen=True)
class ArmSubject(TrialSubject):
    """Equations of an arm that have answered.

    probes: the same equations on other arms; perform: asks more questions.
    """

    request: TrialRequest
    problem: VerificationProblem
    probes: Sequence[VerificationProblem]
    results: Results
    perform: Perform
    whole = WHOLE
    make_answer_keys = staticmethod(make_arm_answer_keys)

    @classmethod
    @contextmanager
    def ask(cls, request: TrialRequest, progress: ProgressCallback) -> Iterator[ArmSubject]:
        """Ask the equations and the models. Raises InputError, and Unfinished."""
        with track_foreign_code(request.name):
            problem = build_problem(request)
            probes = build_probe_problems(problem)
        entry = make_registry_entry(problem.name, problem.equations, problem.has)
        with register(problem.name, entry), Workers(request.jobs) as workers:
            first, failed_parts = ask_functions(problem, workers, progress)

            def perform(tasks: Sequence[ModelTask]) -> Results:
                """Ask what can be asked; a function that fails is called no more."""
                without = skip_dependent_tasks(problem, tasks, failed_parts)
                new = [each for each in tasks if each not in without]
                new = [each for each in new if each.key not in first.outcomes]
                outcomes: dict[Any, Any] = {task.key: why for task, why in without.items()}
                outcomes |= run_tasks(workers, new, progress).outcomes
                for key, bad in outcomes.items():
                    outcomes[key] = describe_failure(bad) if isinstance(bad, BadAnswer) else bad
                return Results({**outcomes, **first.outcomes})

            results = perform(list_tasks(problem, probes, request))
            try:
                with track_foreign_code(request.name, JUDGING_S):
                    yield cls(request, problem, probes, results, perform)
            except comparison.MissingResult as error:
                raise Unfinished(f"{problem.name} cannot be judged: {error}") from None

    @staticmethod
    def run_variants(request: TrialRequest, run: RunTrial) -> Trial:
        """The trial; again with 0 for inertias that equations leave out and are next to nothing."""
        trial = run(request)
        points = find_negligible_inertias(request.mechanism, trial.diagnosis.left_out)
        if not points:
            return trial
        arm = replace_numbers(request.mechanism, dict.fromkeys(points, 0.0))
        trial = run(replace(request, mechanism=arm))
        return replace(trial, notes=(describe_point_masses(points), *trial.notes))

    @staticmethod
    def select_laws(request: TrialRequest) -> Switches:
        """The laws of gears that the equations follow."""
        return select_switches(request.equations, request.mechanism, request.switches)

    def measure_levels(self) -> list[LevelDistance]:
        """How far the equations are from each level that has what they read, the nearest first."""
        problem, wrong = self.problem, dict[LevelDistance, set[str]]()
        if problem.gearing != "rigid":
            return []
        levels = find_distinct_levels(problem.mechanism)
        levels = tuple(level for level in levels if level in problem.levels) or problem.levels
        sizes = problem.compute_sizes(levels[-1])  # same for all
        for level in levels:
            compared = self._compare(level)
            places = {  # two of M that mirror each other are one
                (place.part, place.rates, frozenset((place.row, place.column)))
                for place in (each.place for each in compared.wrong_entries)
            }
            right, errors = compared.reference_values, []
            for part, values in compared.user_values.items():
                errors.append(deviations(values, right[part], sizes.entry_sizes(part)))
            wrong[measure_distance(level, len(places), errors)] = {part for part, *_ in places}
        distances = sort_distances(wrong)
        if not (problem.equations.any_arm and distances[0].entries and distances[1:]):
            return distances
        # Who reads motors' masses means a level that has them, however near another one is.
        asked = [Dependence(self._compare(each.level), self.perform) for each in distances]
        poor = {each.comparison.level for each in asked if each.is_of_richer_level}
        return [each for each in distances if each.level not in poor] or distances

    def diagnose(self, distances: Sequence[LevelDistance]) -> TrialDiagnosis:
        """Find the level, then other coordinates in which all is right, then reasons by entry."""
        problem = self.problem
        level = self._select_equal_level(distances[0].level if distances else "")
        here = self._compare(level)
        wrong_parts = {wrong.place.part for wrong in here.wrong_entries}
        reading_level, readings = "", list[Reading]()
        values = suite.collect_answers(problem, self.results).values if wrong_parts else {}
        if "mass_matrix" in wrong_parts or (wrong_parts and "mass_matrix" not in problem.has):
            reading_level, readings = find_readings(problem, values)
        level = reading_level or level
        changes = LevelChanges(level, [])
        if wrong_parts and not readings and self._is_searched_by_numbers:
            arms = {each.level: self._compare(each.level) for each in distances}
            nearest = find_changes(arms, distances, self._compare_probes)
            changes = nearest if nearest.words else changes
        level = changes.level
        here = self._compare(level)
        is_explained = bool(readings or changes.words)
        is_open = bool(wrong_parts and level) and not is_explained
        is_open = is_open and problem.equations.has_open_angles
        if is_explained:
            diagnosis = Diagnosis(list(here.wrong_entries), [], [])
        else:
            diagnosis = diagnose(here, self._compare_probes(level), self.perform)
        names = problem.names
        causes = [*changes.words, *(f"right in {each.described}" for each in readings)]
        entries = [name_entry(each, names, causes) for each in diagnosis.wrong_entries]
        if no_force := _describe_default_force(problem):
            entries = [replace(e, notes=(no_force,)) if e.part == "force" else e for e in entries]
        lone = () if readings else self._find_lone_accelerations(level)
        accelerations = [name_entry(each, names, ()) for each in lone]
        wrong = (*(each for each in entries if not each.shown_on), *accelerations)
        numbers = tuple(each for each in diagnosis.ignored_numbers if each.parts)
        notes, unexplained = describe_entries(accelerations if is_explained else wrong)
        return TrialDiagnosis(
            level,
            wrong,
            tuple(notes),
            tuple(unexplained),
            explanations=tuple(changes.words),
            is_unusual=changes.is_unusual,
            readings=tuple(each.described for each in readings),
            hidden=tuple(each for each in entries if each.shown_on),
            ignored_numbers=numbers,
            left_out=tuple(each.name for each in (*numbers, *diagnosis.uncertain) if each.parts),
            is_nearer_absolute=is_open and is_nearer_absolute(problem, values, level),
        )

    def _find_lone_accelerations(self, level: str) -> Iterator[EntryMismatch]:
        """The wrong accelerations, unless they are what the other parts make."""
        answers = suite.collect_answers(self.problem, self.results)
        right = self.problem.find_right(level, "acceleration")
        if right is not None and any(
            e.check == SECOND_LAW and e.places for e in answers.identities
        ):
            given, sizes = answers.values["acceleration"], self.problem.compute_sizes(level)
            for wrong in find_wrong_entries("acceleration", given, right, sizes):
                yield replace(wrong, notes=(LONE,))

    @property
    def _is_searched_by_numbers(self) -> bool:
        """Whether other numbers of the arm's file are tried, for answers without a source.

        That is for a rigid arm in a linear map of the joints' angles.
        """
        equations, matrix = self.problem.equations, self.problem.frame.matrix
        has_source = equations.any_arm and equations.table is None
        return not has_source and self.problem.gearing == "rigid" and matrix is not None

    def _compare(self, level: str) -> EntryComparison:
        return compare_entries(self.problem, level, self.results)

    def _compare_probes(self, level: str) -> list[EntryComparison]:
        return [compare_entries(each, level, self.results) for each in self.probes]

    def _select_equal_level(self, level: str) -> str:
        """Pick, among levels that are equal on the arm, as without motors, that of the other arms.

        There it is the one from which the fewest entries differ; of as many the given one.
        """
        groups, levels = group_equal_levels(self.problem.case.arm), self.problem.levels
        others = {each for probe in self.probes for each in find_distinct_levels(probe.mechanism)}
        equal = [each for group in groups if level in group for each in group if each in others]
        equal = [level, *(each for each in equal if each in levels and each != level)]
        if len(equal) < 2:
            return level

        def count_wrong_entries(each: str) -> int:
            return sum(len(list(probe.wrong_entries)) for probe in self._compare_probes(each))

        return min(equal, key=count_wrong_entries)

    def collect_answers(self, level: str) -> AnswerSet:
        """The answers, to be judged by sizes of the user's unit."""
        return suite.collect_answers(self.problem, self.results)

    def judge_engines(self, answers: AnswerSet, level: str) -> Iterator[Finding]:
        """Compare answers with all engines, runs with those of the level, and judge balances."""
        yield from suite.judge_engines(self.problem, answers, level)
        planned = list(_plan_comparisons(self.problem, self.request, [level]))
        yield from comparison.judge_comparisons(planned, self.results)

    def list_runs(self, level: str) -> tuple[dict[Any, Any], dict[Any, Any]]:
        """Cases and runs of scenarios, by key."""
        cases = cases_by_run(list(_plan_comparisons(self.problem, self.request, [level])))
        runs = runs_by_key(self.results).items()
        return cases, {key: run for key, run in runs if key in cases}

    def measure_errors(self, level: str) -> tuple[dict[str, np.ndarray], dict[str, float]]:
        """By part, the relative error of each entry from a level, and what is allowed."""
        here = self._compare(level)
        made = {"force"} - self.problem.bound.given  # of gravity and torques
        errors = {part: each for part, each in here.relative_errors.items() if part not in made}
        given = self.results.get(self.problem.ask_equations("acceleration"))
        right = self.problem.find_right(level, "acceleration")
        has_acceleration = self.problem.equations.acceleration is not None
        if has_acceleration and given is not None and right is not None:
            errors["acceleration"] = deviations(given, right, here.sizes.acceleration)
        return errors, {quantity: here.sizes.tolerance(quantity) for quantity in errors}

    def list_remarks(self) -> Iterator[str]:
        """Sentences on coordinates, on other arms, and on digits of tables."""
        where = f"on this arm {ALONE}"
        if count := len(self.probes):
            others = f"{count} other arm{'s' * (count > 1)}"
            where = f"also on {others}, to catch errors that equal values here would hide"
        yield f"compared in {', '.join(self.problem.names)}, {where}"
        yield from self.problem.bound.readings
        table = self.problem.equations.table
        if table is not None and table.precision:
            single = table.precision == SINGLE
            precision = "single precision" if single else "fewer digits than a double has"
            yield f"answers have {precision}, {table.precision:.2g} relative: the tolerances follow"

    def list_notes(self, diagnosis: TrialDiagnosis) -> list[str]:
        """Numbers that are not followed, and errors on other arms alone."""
        wrong_parts = {wrong.part for wrong in diagnosis.entries}
        written = {
            number.name
            for number in diagnosis.ignored_numbers
            if any(has_literal(self.problem.equations, e, number.value) for e in number.parts)
        }
        arm = self.problem.case.arm
        in_file = {name for name in list_number_names(arm) if get_number(arm, name)}
        note = describe_unfollowed(diagnosis.ignored_numbers, wrong_parts, written, in_file)
        lines = [line for lines in describe_entries(diagnosis.hidden) for line in lines]
        front = "Right on this arm. On others, whose numbers differ, this is wrong: "
        return [*[note] * bool(note), *(f"{front}{line}" for line in lines)]


def _describe_default_force(problem: VerificationProblem) -> str:
    """What is lacking in a force that is not given, of an arm with friction; else ''."""
    friction = [each.friction_N_m_s_per_rad for each in problem.case.arm.joints]
    bound = problem.bound
    if "force" in bound.given or FRICTION in bound.left or not any(friction):
        return ""
    listed = ", ".join(f"{each:g}" for each in friction)
    return (
        "no force is given, so it is the motors' torques;"
        f" this arm's joints have friction ({listed} N m s/rad)"
    )


def list_tasks(
    problem: VerificationProblem, probes: Sequence[VerificationProblem], request: TrialRequest
) -> list[ModelTask]:
    """All tasks of a trial: what the equations are asked, and runs."""
    planned = list(_plan_comparisons(problem, request, problem.levels))
    questions = [problem.ask_equations(quantity) for quantity in suite.list_quantities(problem)]
    for each in (problem, *probes):
        questions += list_entry_questions(each)
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
    """Whether a scenario has a torque on a joint at any time: torques and gains are in N m."""
    fields = scenario.drive.model_dump().items()
    factors = [expand_to_joints(each, len(arm.joints)) for name, each in fields if "N_m" in name]
    return any(np.any(each[joint]) for each in factors)


# Equations of which it is not known yet what their parts hold, for the worker that finds out.
_unread = dict[int, SuppliedEquations]()
_numbers = count()


@dataclass(frozen=True)
class ReadingTask(SelfKeyedTask):
    """The task of finding out what parts hold: the user's functions may end a process."""

    number: int
    cost = 1.0

    @return_failures
    def perform(self) -> PartReading:
        """What parts hold, or a Failure."""
        return find_part_reading(_unread[self.number])


def _find_reading(equations: Equations, arm: Arm) -> PartReading:
    """What parts of equations hold; nothing where they do not say so."""
    unread = replace(equations, reading=PartReading())
    bound = bind_equations(unread, arm, build_frame(equations.coordinates, arm))
    if equations.coordinates.gearing != "rigid" or not PARTS_OF_MOTION & bound.given:
        return PartReading()
    if equations.table is not None:
        return find_part_reading(bound)
    task = ReadingTask(next(_numbers))
    _unread[task.number] = bound
    try:
        with Workers(1) as workers:
            outcome = workers.perform([task])[task]
    finally:
        del _unread[task.number]
    return outcome if isinstance(outcome, PartReading) else PartReading()


def build_problem(request: TrialRequest) -> VerificationProblem:
    """The supplied equations, with coordinates and states already made. Raises InputError."""
    make_cross_check_request(request)  # refuses scenarios that cannot be run together
    arm: Arm = request.mechanism
    laws = select_switches(request.equations, arm, request.switches)
    count = QUICK_STATES if request.quick else STATES
    scenario = make_experiment(arm, range(len(arm.joints)))
    equations = request.equations.adapt_to_arm(arm, scenario)
    equations = replace(equations, reading=_find_reading(equations, arm))
    bound = bind_equations(equations, arm, build_frame(equations.coordinates, arm))
    if len(bound.motors) < len(arm.joints):
        scenario = make_experiment(arm, bound.motors)
        equations = equations.adapt_to_arm(arm, scenario)
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
    _ = problem.states  # made first, so that errors in the coordinates are reported first
    return problem


def _plan_comparisons(
    problem: VerificationProblem, request: TrialRequest, levels: Sequence[str]
) -> Iterator[Comparison]:
    """The comparisons of runs at levels, and the balances."""
    for level in levels:
        for scenario in request.scenarios:
            yield from suite.plan_run_comparisons(problem, scenario, level)
    yield from suite.plan_balance_checks(problem)
