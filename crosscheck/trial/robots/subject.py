"""A robot's equations in a trial: asked in workers, beside every level."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from crosscheck.checks.robot_states import WITH_WEIGHTS, RandomStates, RobotSizes
from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import Level, Robot, remove_friction
from crosscheck.registry import Entry, register
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.progress_update import ProgressCallback
from crosscheck.runner.workers import Workers
from crosscheck.trial.coordinates.functions import map_calls
from crosscheck.trial.coordinates.robots import build_robot_frame, place_states
from crosscheck.trial.input.calls import LOADS
from crosscheck.trial.input.loading import require_robot_equations
from crosscheck.trial.judge.entries import LevelDistance
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.result import Trial, TrialDiagnosis
from crosscheck.trial.robots.answer_keys import make_robot_answer_keys
from crosscheck.trial.robots.answers import (
    BY_RATES,
    NONLINEAR,
    QUICK_STATES,
    STATES,
    Call,
    Friction,
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
    BiasTerms,
    SlopeSides,
    compare_with_itself,
    compute_bias_terms,
    make_rate_states,
    make_slope_states,
    select_rate_states,
)
from crosscheck.trial.robots.elastic import ELASTIC, build_elastic_robot, drive_motors
from crosscheck.trial.robots.explain import Rates, diagnose
from crosscheck.trial.robots.judge import SINGLE, RobotProblem, compute_sizes_by_level
from crosscheck.trial.trial import RunTrial, TrialSubject


@dataclass(frozen=True)
class RobotSubject(RobotProblem, TrialSubject):
    """Equations of a robot that have answered; rates: asks for the terms of their bias."""

    rates: Rates | None = None
    whole, explains_faults = SINGLE, True
    make_answer_keys = staticmethod(make_robot_answer_keys)

    @property
    def problem(self) -> RobotProblem:
        """The equations, and what they are compared with."""
        return self

    @classmethod
    @contextmanager
    def ask(cls, request: TrialRequest, progress: ProgressCallback) -> Iterator[RobotSubject]:
        """Ask the equations. Raises InputError for answers that can be none of this robot."""
        name, equations, robot = request.name, request.equations, request.mechanism
        require_robot_equations(equations, name)
        stiffness = np.zeros((1, 1))
        if equations.level == ELASTIC:
            robot, stiffness = build_elastic_robot(robot, name)
            equations = drive_motors(equations, robot)
        friction, is_rubbing = read_friction(equations, robot, name), bool(robot.friction.any())
        robot = remove_friction(robot)
        questions = prepare_questions(replace(request, equations=equations, mechanism=robot))
        motors, states, sizes = questions.motors, questions.states, questions.sizes
        with register(name, questions.entry), Workers(request.jobs) as workers:
            call = partial(call_functions, name, workers, progress)
            answers = ask(name, robot, states, sizes[questions.level], friction, call)
            second = _ask_about_itself(questions, answers, call)
            taken = friction.torques(states.v)
            pushed = states._replace(torques=states.torques - taken)
            given = name, robot, pushed, sizes, answers, equations.level, *second, taken, stiffness
            rates = partial(_ask_bias_terms, questions, answers, friction, call)
            yield cls(*given, equations, motors, questions.is_mapped, is_rubbing, rates)

    @staticmethod
    def run_variants(request: TrialRequest, run: RunTrial) -> Trial:
        """The trial, or that with the motor at which the fewest entries differ.

        Only where no equations state which joints have a motor, and a function takes no torque for
        each joint. Raises InputError for equations that cannot be judged.
        """
        equations = request.equations
        loads = [
            part for part in LOADS if getattr(equations, part) is not None and not equations.table
        ]
        try:
            whole = [run(request)]
        except InputError:
            single = _run_with_single_motor(request, run) if loads else []
            if not single:
                raise
        else:
            failed = [part for part in loads if part in whole[0].failures]
            single = (_run_with_single_motor(request, run) if failed else []) or whole
        return min(single, key=lambda each: len(each.diagnosis.entries))

    def diagnose(self, distances: Sequence[LevelDistance]) -> TrialDiagnosis:
        """Find other coordinates in which all is right, then one change, then single parts."""
        if not distances:
            return TrialDiagnosis(self.stated or next(iter(self.sizes)))
        assert self.rates is not None  # as they are of equations that were asked
        return diagnose(self, distances, self.rates)


def _run_with_single_motor(request: TrialRequest, run: RunTrial) -> list[Trial]:
    """The trials with a motor at one joint in which every function of torques answers."""
    trials, joints = list[Trial](), len(request.mechanism.coordinates)
    for joint in range(joints if request.equations.drive is None and joints > 1 else 0):
        equations = replace(request.equations, drive=[joint + 1])
        with suppress(InputError):
            trials.append(run(replace(request, equations=equations)))
    return [each for each in trials if not set(each.failures) & set(LOADS)]


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
    again = calls if table is None else bind_functions(replace(table.again, table=table), robot)[1]
    frame = build_robot_frame(equations.coordinates, robot, name)
    states = draw_states(robot, QUICK_STATES if request.quick else STATES, request.seed, motors)
    states = place_states(states, frame)
    sizes = compute_sizes_by_level(robot, equations.level, states)
    level = next((each for each in sizes if each == equations.level), next(iter(sizes)))
    entry = make_robot_entry(*(map_calls(each, frame, name) for each in (calls, again)))
    is_mapped = not frame.is_identity
    return RobotQuestions(name, robot, entry, motors, states, sizes, level, is_mapped)


def _ask_bias_terms(
    questions: RobotQuestions, answers: RobotAnswers, friction: Friction, call: Call
) -> BiasTerms | None:
    """The bias term by term, of more answers; None if these fail."""
    source = answers.sources["bias"]
    states = make_rate_states(select_rate_states(questions.states))
    part = "bias" if source == NONLINEAR else source
    (answer,) = call({part: states}).values()
    if isinstance(answer, Failure):
        return None
    parts = np.split(answer, len(states))
    pairs = list(zip(parts, states, strict=True))
    if part == "inverse_dynamics" or answers.friction_in_bias:
        parts = [each - friction.torques(at.v) for each, at in pairs]
    if part == "coriolis":
        parts = [np.einsum("sij,sj->si", c, each.v) for c, each in pairs]
    if source in WITH_WEIGHTS:
        parts = [each - parts[0] for each in parts]
    return compute_bias_terms(parts)


def _ask_about_itself(
    questions: RobotQuestions, answers: RobotAnswers, call: Call
) -> tuple[dict[str, SlopeSides], dict[str, np.ndarray], dict[str, Failure]]:
    """What functions that answer owe to slopes of others; parts by torques; parts that fail."""
    robot, states = questions.robot, questions.states
    slopes, torques = make_slope_states(robot, states), make_torque_states(states, questions.motors)
    calls = {part: slopes for part in SOURCES if answers.sources.get(part) == part}
    calls |= {part: torques for part in LOADS if part in answers.values and questions.motors}
    outcomes = call(calls) if calls else {}
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
