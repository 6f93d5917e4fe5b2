"""A trial of a user's equations of a robot: ask, compare with every level, explain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.checks.robot_states import WITH_WEIGHTS, RandomStates, RobotSizes
from crosscheck.findings import Agreement
from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import Level, Robot, remove_friction
from crosscheck.provenance import record_provenance
from crosscheck.registry import Entry, packages, register
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.progress_update import ProgressCallback, ignore_progress
from crosscheck.runner.workers import Workers
from crosscheck.trial.coordinates.robots import map_calls, place_states, read_frame
from crosscheck.trial.input.arrays import is_single_precision
from crosscheck.trial.input.calls import LOADS
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.input.loading import require_robot_equations
from crosscheck.trial.judge.checks import SelfCheck, find_idle_motors, judge_answers
from crosscheck.trial.judge.entries import LevelDistance
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.result import TrialResult
from crosscheck.trial.robots.answer_keys import make_robot_answer_keys
from crosscheck.trial.robots.answers import (
    BY_RATES,
    NONLINEAR,
    QUICK_STATES,
    STATES,
    PartTask,
    RobotAnswers,
    ask,
    bind_functions,
    call_functions,
    draw_states,
    make_blocks,
    make_part_task,
    make_robot_entry,
    read_friction,
)
from crosscheck.trial.robots.consistency import (
    FEW_STATES,
    SOURCES,
    SlopeSides,
    compare_with_itself,
    make_slope_states,
)
from crosscheck.trial.robots.elastic import ELASTIC, build_elastic_robot, drive_motors
from crosscheck.trial.robots.explain import RobotDiagnosis, diagnose
from crosscheck.trial.robots.judge import (
    SINGLE,
    RobotProblem,
    compute_sizes_by_level,
    judge_engines,
)
from crosscheck.trial.robots.rates import (
    BiasTerms,
    compute_bias_terms,
    make_rate_states,
    select_rate_states,
)
from crosscheck.trial.source.code import find_code
from crosscheck.trial.source.search import MakeAnswerKeys, find_source_answer
from crosscheck.trial.source.source_edit import SourceAnswer

if TYPE_CHECKING:
    from crosscheck.report.trials.answer import TrialAnswer


@dataclass(frozen=True, repr=False)
class RobotTrial(TrialResult):
    """A user's equations of a robot, judged.

    stated: the level that they are to be of, '' for any; parts: that were judged; remarks: how the
    equations were read; not_judged: what was not judged, with the reason, in words; distances:
    of each level, the nearest first; failures: by part that did not answer; checks: all of them;
    relative_errors: by part, how far each entry is from the diagnosis' level at most, of its size;
    allowed: how far it may be; seed: of the states; is_single_precision: whether a function answers
    in no more digits; source_answer: what must change in the user's source, where a small edit
    mends it; self_checks: what the equations owe to themselves, judged.
    """

    name: str
    equations: Equations
    robot: Robot
    stated: str
    parts: tuple[str, ...]
    remarks: tuple[str, ...]
    not_judged: tuple[str, ...]
    distances: tuple[LevelDistance, ...]
    diagnosis: RobotDiagnosis
    failures: Mapping[str, Failure]
    checks: Agreement
    relative_errors: Mapping[str, np.ndarray]
    allowed: Mapping[str, float]
    seed: int
    is_single_precision: bool = False
    source_answer: SourceAnswer | None = None
    self_checks: tuple[SelfCheck, ...] = ()

    @property
    def agreement(self) -> Agreement:
        """All checks of the trial."""
        return self.checks

    @property
    def answer(self) -> TrialAnswer:
        """What the trial has to say, the most important first."""
        from crosscheck.report.trials.robot import answer_robot_trial

        return answer_robot_trial(self)

    @property
    def agrees(self) -> bool:
        """Whether all that was judged agrees with the level and every engine."""
        return self.exit_code == 0

    @property
    def level(self) -> str:
        """The level that the equations are beside."""
        return ELASTIC if self.stated == ELASTIC else self.diagnosis.level

    @property
    def largest(self) -> float:
        """The largest difference from the level, as a part of the entry's size; 0 of no part."""
        level = self.diagnosis.level
        return next((each.largest for each in self.distances if each.level == level), 0.0)


def run_robot_trial(
    request: TrialRequest, progress: ProgressCallback = ignore_progress
) -> RobotTrial:
    """Judge a user's equations of a robot.

    Where none states which joints have a motor, and a function takes no torque for each joint, it
    is tried with one motor, at the joint at which the fewest entries differ. Raises InputError for
    equations that cannot be judged, and for answers of another shape.
    """
    equations = request.equations
    loads = [part for part in LOADS if getattr(equations, part) is not None and not equations.table]
    try:
        whole = _run_trial(request, progress)
    except InputError:
        single = _run_with_one_motor(request, progress) if loads else []
        if not single:
            raise
    else:
        failed = [part for part in loads if part in whole[0].failures]
        single = (_run_with_one_motor(request, progress) if failed else []) or [whole]
    trial, make_answer_keys = min(single, key=lambda each: len(each[0].diagnosis.entries))
    code = find_code(equations) if make_answer_keys else None
    if code is None or make_answer_keys is None:
        return trial
    return replace(trial, source_answer=find_source_answer(code, make_answer_keys, progress))


def _run_with_one_motor(request: TrialRequest, progress: ProgressCallback) -> list[RunTrial]:
    """The trials with a motor at one joint in which every function of torques answers."""
    trials, joints = list[RunTrial](), len(request.mechanism.coordinates)
    for joint in range(joints if request.equations.drive is None and joints > 1 else 0):
        equations = replace(request.equations, drive=[joint + 1])
        with suppress(InputError):
            trials.append(_run_trial(replace(request, equations=equations), progress))
    return [each for each in trials if not set(each[0].failures) & set(LOADS)]


# A trial, and what makes the answer keys of a search for wrong lines; None where there is no need.
RunTrial = tuple[RobotTrial, MakeAnswerKeys | None]


@dataclass(frozen=True)
class RobotQuestions:
    """All calls of a robot's equations in a trial; none depends on an answer.

    entry: the equations' functions in the registry; motors: coordinates, from 0, that have one;
    sizes: by level, of which ``level`` sets the accelerations at which inverse dynamics is asked.
    """

    name: str
    robot: Robot
    entry: Entry
    motors: tuple[int, ...]
    states: RandomStates
    sizes: Mapping[Level, RobotSizes]
    level: Level
    is_mapped: bool

    def list_tasks(self, part: str) -> list[PartTask]:
        """All that a part may be asked: at the states, and where a wrong part is looked into."""
        rounds = [list(make_blocks(part, self.states, self.sizes[self.level]).values())]
        if part in SOURCES:
            rounds.append(make_slope_states(self.robot, self.states))
        if part in BY_RATES:
            rounds.append(make_rate_states(select_rate_states(self.states)))
        if part in LOADS:
            rounds.append(make_torque_states(self.states, self.motors))
        return [make_part_task(self.name, part, blocks) for blocks in rounds]


def prepare_questions(request: TrialRequest) -> RobotQuestions:
    """Prepare the calls of a robot's equations. Raises InputError."""
    name, equations, robot = request.name, request.equations, request.mechanism
    motors, calls = bind_functions(equations, robot)
    table = equations.table
    again = calls if table is None else bind_functions(table.again, robot)[1]
    frame = read_frame(equations.coordinates, robot, name)
    functions: list[dict[str, Any]] = [dict(calls), dict(again)]
    states = draw_states(robot, QUICK_STATES if request.quick else STATES, request.seed, motors)
    if frame is not None:
        functions = [map_calls(each, frame, name) for each in functions]
        states = place_states(states, frame)
    sizes = compute_sizes_by_level(robot, equations.level, states)
    level = next((each for each in sizes if each == equations.level), next(iter(sizes)))
    entry = make_robot_entry(*functions)
    return RobotQuestions(
        name, robot, entry, motors, states, sizes, level, is_mapped=frame is not None
    )


def _run_trial(request: TrialRequest, progress: ProgressCallback) -> RunTrial:
    name, equations, robot = request.name, request.equations, request.mechanism
    require_robot_equations(equations, name)
    given, stated, stiffness = robot, equations.level, np.zeros((1, 1))
    if stated == ELASTIC:
        robot, stiffness = build_elastic_robot(robot, name)
        equations = drive_motors(equations, robot)
    friction = read_friction(equations, robot, name)
    is_rubbing, robot = bool(robot.friction.any()), remove_friction(robot)
    questions = prepare_questions(replace(request, equations=equations, mechanism=robot))
    motors, states, sizes = questions.motors, questions.states, questions.sizes
    level = questions.level
    with register(name, questions.entry), Workers(request.jobs) as workers:
        answers = ask(name, robot, states, sizes[level], friction, workers, progress)
        second = _ask_about_itself(questions, answers, workers, progress)
        taken = friction.torques(states.v)
        pushed = states._replace(torques=states.torques - taken)
        problem = RobotProblem(
            name, robot, pushed, sizes, answers, equations.level, *second, taken, stiffness
        )

        def rates() -> BiasTerms | None:
            source = answers.sources["bias"]
            sampled_states = make_rate_states(select_rate_states(states))
            source = "bias" if source == NONLINEAR else source
            (answer,) = call_functions({source: sampled_states}, name, workers, progress).values()
            if isinstance(answer, Failure):
                return None
            parts = np.split(answer, len(sampled_states))
            if source == "inverse_dynamics" or answers.friction_in_bias:
                rated = zip(parts, sampled_states, strict=True)
                parts = [each - friction.torques(at.v) for each, at in rated]
            if source == "coriolis":
                pairs = zip(parts, sampled_states, strict=True)
                parts = [np.einsum("sij,sj->si", c, each.v) for c, each in pairs]
            if answers.sources["bias"] in WITH_WEIGHTS:
                parts = [each - parts[0] for each in parts]
            return compute_bias_terms(parts)

        distances = tuple(problem.distances()) if problem.parts else ()
        diagnosis = RobotDiagnosis(level)
        if distances:
            diagnosis = diagnose(problem, distances, rates)
        if equations.drive is None and not {each.part for each in diagnosis.entries} & set(SINGLE):
            idle = find_idle_motors(problem.collect_answers(diagnosis.level), motors)
            notes = _describe_idle_joints(problem.names, motors, idle, equations)
            diagnosis = replace(diagnosis, notes=(*diagnosis.notes, *notes))
    relative_errors = problem.relative_errors(
        diagnosis.level, problem.reference_values[diagnosis.level]
    )
    make_answer_keys = None
    if diagnosis.entries and not diagnosis.readings:
        make_answer_keys = partial(
            make_robot_answer_keys, problem, diagnosis.level, given, equations
        )
    judged = problem.collect_answers(diagnosis.level)
    self_checks = tuple(judge_answers(judged))
    findings = [check.finding for check in self_checks]
    findings += judge_engines(problem, judged, diagnosis.level)
    settings = given, request.seed, request.quick
    record = record_provenance(*settings, packages=packages(), model=name)
    trial = RobotTrial(
        name=name,
        equations=equations,
        robot=robot,
        stated=stated,
        parts=problem.parts,
        remarks=(
            *_list_remarks(problem, motors, is_mapped=questions.is_mapped),
            *["friction of the joints is that of the robot's file"] * is_rubbing,
        ),
        not_judged=tuple(_list_unjudged(problem, equations)),
        distances=distances,
        diagnosis=diagnosis,
        failures=answers.failures,
        checks=Agreement(findings, record),
        relative_errors={part: np.abs(off).max(axis=0) for part, off in relative_errors.items()},
        allowed={part: sizes[diagnosis.level].tolerance(part) for part in problem.parts},
        seed=request.seed,
        is_single_precision=any(map(is_single_precision, answers.again.values())),
        self_checks=self_checks,
    )
    return trial, make_answer_keys


def _ask_about_itself(
    questions: RobotQuestions, answers: RobotAnswers, workers: Workers, progress: ProgressCallback
) -> tuple[dict[str, SlopeSides], dict[str, np.ndarray], dict[str, Failure]]:
    """What functions that answer owe to slopes of others; parts by torques; parts that fail."""
    robot, states = questions.robot, questions.states
    slopes, torques = make_slope_states(robot, states), make_torque_states(states, questions.motors)
    calls = {part: slopes for part in SOURCES if answers.sources.get(part) == part}
    calls |= {part: torques for part in LOADS if part in answers.values and questions.motors}
    outcomes = call_functions(calls, questions.name, workers, progress) if calls else {}
    failures = {part: each for part, each in outcomes.items() if isinstance(each, Failure)}
    by_torques = {
        part: np.stack(np.split(each, len(torques)), axis=1)
        for part, each in outcomes.items()
        if part in LOADS and not isinstance(each, Failure)
    }
    values = dict(answers.values)
    if answers.other_speeds is not None and answers.sources["bias"] == "bias":
        # The bias at rest is reported separately.
        values["bias"] = values["bias"] - answers.other_speeds[:, -1]
    return compare_with_itself(robot, states, values, outcomes), by_torques, failures


def make_torque_states(states: RandomStates, motors: Sequence[int]) -> list[RandomStates]:
    """The first states at no torque, each alone, twice each alone, and all together."""
    few = states.first(FEW_STATES)
    alone = [np.isin(np.arange(few.q.shape[1]), motor) for motor in motors]
    factors = [0.0, *alone, *(2 * each for each in alone), 1.0]
    return [few._replace(torques=factor * few.torques) for factor in factors]


def _list_remarks(
    problem: RobotProblem, motors: Sequence[int], *, is_mapped: bool
) -> Iterator[str]:
    """Sentences on how the equations were read, where they may be read in several ways."""
    if is_mapped:
        yield "carried from your coordinates to the joints' own, in which entries are named"
    if len(motors) < len(problem.names):
        joints = ", ".join(problem.names[number] for number in motors)
        yield f"motors: at {joints} alone" if motors else "motors: nowhere"
    if problem.answers.sources.get("bias") == NONLINEAR:
        yield "bias is not 0 at rest: read as nonlinear effects, C v + g, of which g is its gravity"
    if problem.answers.driven:
        yield "force is the motors' torques alone: the weights are read as gravity, on the left"


def _describe_idle_joints(
    names: Sequence[str], motors: Sequence[int], idle: Sequence[int], equations: Equations
) -> Iterator[str]:
    """The sentence that torques of some joints are nowhere in the equations."""
    if idle:
        driven = [names[number] for number in motors if number not in idle]
        joints = ", ".join(names[number] for number in idle)
        remedy = (
            f"state drive = {driven}" if equations.table is None else "answer gravity for force"
        )
        yield f"missing: the torque of {joints}; where there is no motor, {remedy}"


def _list_unjudged(problem: RobotProblem, equations: Equations) -> Iterator[str]:
    """Parts of the equations that are not judged, each with the reason."""
    failures = problem.answers.failures
    yield from (f"{part} ({why.kind})" for part, why in failures.items())
    for part in SINGLE:
        by = "coriolis" if part == "bias" else ""
        if part not in problem.parts and not {part, by, "inverse_dynamics"} & set(failures):
            weightless = part == "gravity" and problem.answers.weightless
            yield f"{part} ({'inverse_dynamics leaves it out' if weightless else 'not supplied'})"
    yield from (f"{name} (no part of equations)" for name in equations.unused)
