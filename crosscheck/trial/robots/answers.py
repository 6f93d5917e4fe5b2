"""Answers of a user's robot equations at random states; their code runs in workers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.answers import BadAnswer
from crosscheck.checks.robot_states import TOLERANCE, RandomStates, RobotSizes, sample_states
from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import Robot
from crosscheck.registry import MODELS, Entry
from crosscheck.report.formatting import format_count
from crosscheck.run import run_tasks
from crosscheck.runner.outcomes import Failure, SelfKeyedTask
from crosscheck.runner.progress_update import ProgressCallback
from crosscheck.runner.workers import Workers
from crosscheck.trial.input.arrays import NotNumbers, convert_to_numbers
from crosscheck.trial.input.calls import (
    TAKES,
    MotorCall,
    NamedCall,
    add_motors,
    call_part,
    describe_failure,
    find_motors,
    make_named_calls,
)
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.input.loading import FRICTION

STATES, QUICK_STATES = 12, 8
FASTEST = 2.0  # rad/s or m/s of a state, whatever the joint's limit: equations hold beyond it
CALL_S = 2e-3  # [s] that a user's Python takes over one answer, at most
LARGEST = 1e50  # largest number that can be compared
RESTATED = 1e-9  # relative tolerance between friction of the equations and of the robot's file
HERE, AGAIN = "here", "again"  # the states, and the same a second time in the other order
NONLINEAR = "nonlinear effects"  # C v + gravity: what a bias is that counts the weights
SPEEDS = (1.0, -1.0, 2.0, 0.0)  # factors on each state's rates at which the bias is evaluated
ARGUMENTS = ("x", "v", "a", "torque")  # what functions call the arrays of RandomStates
BY_RATES = ("bias", "coriolis", "inverse_dynamics")  # parts that give the bias
Block = str | float | tuple[int]  # HERE, AGAIN, one of SPEEDS, or (joint,) that accelerates alone
Blocks = dict[Block, np.ndarray]  # answers of a function to each block of states
# Of functions by their part, at blocks of states.
Call = Callable[[Mapping[str, Sequence[RandomStates]]], dict[str, np.ndarray | Failure]]


@dataclass(frozen=True)
class PartTask(SelfKeyedTask):
    """A task: a function of a user's equations, called with each row of its arguments.

    size: n, the number of coordinates; arguments (rows, n) by TAKES, t (rows,).
    """

    model: str
    quantity: str
    size: int
    arguments: Mapping[str, np.ndarray] = field(compare=False, repr=False)

    @property
    def rows(self) -> int:
        """How many times the function is called."""
        return len(self.arguments["x"])

    @property
    def cost(self) -> float:
        """Estimated time that the answers take [s]."""
        return 0.5 + self.rows * CALL_S

    def perform(self) -> np.ndarray | Failure | InputError:
        """The answers, row by row, or why there are none; an InputError if the first is unfit."""
        first, again = (each[self.quantity] for each in _find_functions(self.model))
        answers, asked = list[np.ndarray](), set[bytes]()
        try:
            for row in range(self.rows):
                row_arguments = {name: values[row] for name, values in self.arguments.items()}
                key = b"".join(value.tobytes() for value in row_arguments.values())
                call = again if key in asked else first
                asked.add(key)
                answer = call_part(call, self.quantity, self.size, row_arguments, "q")
                if not (np.abs(answer) <= LARGEST).all():
                    most = f"{LARGEST:g}, the most that can be compared"
                    raise BadAnswer(f"{self.quantity} is larger than {most}")
                answers.append(answer)
        except BadAnswer as error:
            if not answers:
                count = format_count(self.size, "coordinate")
                about = f"{error}; there {'is' if self.size == 1 else 'are'} {count}"
                return InputError(self.model, "", None, about)
            return describe_failure(error)
        except BaseException as error:  # also SystemExit and KeyboardInterrupt of the user's code
            return describe_failure(error)
        return np.array(answers)


@dataclass(frozen=True)
class Friction:
    """Friction that equations state: viscous [N m s/rad] and Coulomb's [N m], (n,) each."""

    viscous: np.ndarray
    coulomb: np.ndarray

    @property
    def is_stated(self) -> bool:
        """Whether there is any."""
        return bool(self.viscous.any() or self.coulomb.any())

    def torques(self, v: np.ndarray) -> np.ndarray:
        """Friction torque at rates v (states, n), which the motors overcome."""
        return self.viscous * v + self.coulomb * np.sign(v)


def read_friction(equations: Equations, robot: Robot, where: str) -> Friction:
    """The friction that equations state, else that of the robot's file. Raises InputError.

    robot: with the friction of its file, which equations may state again, but not otherwise.
    """
    size, values = len(robot.coordinates), list[np.ndarray]()
    for name in FRICTION:
        stated = getattr(equations, name)
        try:
            values.append(np.zeros(size) if stated is None else convert_to_numbers(stated, (size,)))
        except NotNumbers as error:
            reason = f"{error}: a number for each of {', '.join(robot.coordinate_names)}"
            raise InputError(where, name, None, reason) from None
    viscous, coulomb = values
    if robot.friction.any():
        if equations.viscous_friction is None:
            viscous = robot.friction
        elif not np.allclose(viscous, robot.friction, rtol=RESTATED, atol=0.0):
            listed = ", ".join(f"{each:.6g}" for each in robot.friction)
            reason = f"must be left out, or as the robot's file has it: {listed}"
            raise InputError(where, FRICTION[0], None, reason)
    return Friction(viscous, coulomb)


@dataclass(frozen=True)
class RobotAnswers:
    """Answers of a user's equations by quantity: M (states, n, n), others (states, n).

    again: the same, asked a second time in the other order. sources: the part that each comes from.
    other_speeds (states, 3, n): the bias at -1 and 2 times the rates over the square of these
    factors, then at rest; None without a bias. failures: by part. weightless: whether
    inverse_dynamics is M a + bias and leaves the weights out; driven: whether force is the motors'
    torques alone, the weights on the left of the equation; friction_in_bias: whether a bias held
    the friction that is stated. Bias and inverse_dynamics are those without friction. A bias that
    is not 0 at rest is NONLINEAR where there is no gravity: what it is at rest is judged as that.
    """

    values: Mapping[str, np.ndarray]
    again: Mapping[str, np.ndarray]
    sources: Mapping[str, str]
    other_speeds: np.ndarray | None
    failures: Mapping[str, Failure]
    weightless: bool
    driven: bool = False
    friction_in_bias: bool = False


def draw_states(robot: Robot, count: int, seed: int, motors: Sequence[int]) -> RandomStates:
    """The random states at which equations are asked; torques of these joints' motors alone."""
    states, rng = sample_states(robot, count, seed), np.random.default_rng([seed, 1])
    driven = np.isin(np.arange(states.q.shape[1]), motors)
    return states._replace(
        v=rng.uniform(-FASTEST, FASTEST, states.v.shape), torques=states.torques * driven
    )


def bind_functions(
    equations: Equations, robot: Robot
) -> tuple[tuple[int, ...], dict[str, NamedCall | MotorCall]]:
    """The coordinates that a motor moves, from 0, and the functions of equations by their part.

    Without a statement the robot's passive joints have none; a table has columns of 0 for them.
    Raises InputError.
    """
    stated = equations
    if equations.drive is None and robot.passive:
        stated = replace(equations, drive=[place + 1 for place in robot.motors])
    calls = make_named_calls(equations)
    motors = find_motors(stated, calls, robot.coordinate_names)
    return motors, add_motors(calls, stated if equations.table is None else equations, motors)


def make_robot_entry(calls: Mapping[str, Any], again: Mapping[str, Any]) -> Entry:
    """The entry that stands for the functions of equations in the registry during a trial.

    again: the functions for what a task asks a second time.
    """
    made = type("SuppliedFunctions", (), {"calls": (calls, again)})
    return Entry(__name__, made.__name__, "supplied", frozenset(), call_s=CALL_S, made=made)


def _find_functions(name: str) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
    """The functions that are supplied under a name, and those for what is asked again.

    Forked workers know the registry's entries.
    """
    return vars(MODELS[name].made)["calls"]


def ask(
    name: str, robot: Robot, states: RandomStates, sizes: RobotSizes, friction: Friction, call: Call
) -> RobotAnswers:
    """Ask all functions of the equations of a robot that are supplied under a name.

    call: ``call_functions`` of these. Raises InputError for answers that can be none of this robot.
    """
    blocks = {part: make_blocks(part, states, sizes) for part in _find_functions(name)[0]}
    outcomes = call({part: list(of_part.values()) for part, of_part in blocks.items()})
    failures = {part: each for part, each in outcomes.items() if isinstance(each, Failure)}
    answers = {
        part: dict(zip(blocks[part], np.split(each, len(blocks[part])), strict=True))
        for part, each in outcomes.items()
        if isinstance(each, np.ndarray)
    }
    if "coriolis" in answers:
        answers["bias"] = {
            block: np.einsum("sij,sj->si", matrix, blocks["coriolis"][block].v)
            for block, matrix in answers.pop("coriolis").items()
        }
    holds_friction = _remove_friction(answers, blocks, friction)
    whole = answers.get("inverse_dynamics")
    weights = AnalyticRobot(robot, "links").gravity(states.q)
    has_weights = bool((np.abs(weights) > TOLERANCE * sizes.gravity).any())
    nonlinear = _split_nonlinear_effects(answers, sizes) if "gravity" not in outcomes else {}
    answers |= nonlinear
    values = {quantity: part_blocks[HERE] for quantity, part_blocks in answers.items()}
    derived = {} if whole is None else _derive_values(whole, sizes, has_weights)
    sources = {quantity: quantity for quantity in values}
    sources |= {quantity: "inverse_dynamics" for quantity in derived if quantity not in values}
    if "coriolis" in outcomes and "bias" in values:
        sources["bias"] = "coriolis"
    sources |= dict.fromkeys(nonlinear, NONLINEAR)
    by_rates = answers.get("bias", whole)
    other_speeds = None
    if by_rates is not None:
        rest = by_rates[0.0] if by_rates is whole else 0.0
        rows = [(by_rates[speed] - rest) / max(speed**2, 1.0) for speed in SPEEDS[1:]]
        other_speeds = np.stack(rows, axis=1)
    again = {quantity: part_blocks[AGAIN][::-1] for quantity, part_blocks in answers.items()}
    weightless = whole is not None and "gravity" not in derived
    values = derived | values
    torques = states.torques - (0 if holds_friction else friction.torques(states.v))
    driven = False
    if {"gravity", "force"} <= set(values):
        pushed = values["force"] - torques
        with_them, without = (np.abs(x / sizes.force).sum() for x in (pushed + weights, pushed))
        driven = not with_them < without  # the force is no nearer to the weights than to 0
    return RobotAnswers(
        values, again, sources, other_speeds, failures, weightless, driven, holds_friction
    )


def _remove_friction(
    answers: dict[str, Blocks],
    blocks: Mapping[str, Mapping[Block, RandomStates]],
    friction: Friction,
) -> bool:
    """Take friction out of inverse dynamics, and out of a bias that has it: whether it has.

    A bias has it if what is odd in its rates is nearer to that than to nothing.
    """
    if not friction.is_stated:
        return False
    parts = ["inverse_dynamics"] if "inverse_dynamics" in answers else []
    holds_friction = False
    if "bias" in answers and "bias" in blocks:
        odd = (answers["bias"][1.0] - answers["bias"][-1.0]) / 2
        expected = friction.torques(blocks["bias"][1.0].v)
        holds_friction = np.abs(odd - expected).sum() < np.abs(odd).sum()
    for part in [*parts, *(["bias"] if holds_friction else [])]:
        answers[part] = {
            block: values - friction.torques(blocks[part][block].v)
            for block, values in answers[part].items()
        }
    return bool(holds_friction)


def _split_nonlinear_effects(answers: Mapping[str, Blocks], sizes: RobotSizes) -> dict[str, Blocks]:
    """Bias and gravity by what a bias is at rest; {} if that is 0."""
    bias = answers.get("bias")
    if bias is None or (np.abs(bias[0.0]) <= TOLERANCE * sizes.gravity).all():
        return {}
    rest = {block: bias[0.0][::-1] if block == AGAIN else bias[0.0] for block in bias}
    moving = {block: values - rest[block] for block, values in bias.items()}
    return {"bias": moving, "gravity": {block: rest[block] for block in (HERE, AGAIN)}}


def call_functions(
    name: str,
    workers: Workers,
    progress: ProgressCallback,
    states_by_part: Mapping[str, Sequence[RandomStates]],
) -> dict[str, np.ndarray | Failure]:
    """Call functions of the supplied equations at states, in workers; answers by part.

    Raises InputError for answers that can be none of this robot.
    """
    tasks = {part: make_part_task(name, part, states) for part, states in states_by_part.items()}
    outcomes: Mapping[Any, Any] = run_tasks(workers, list(tasks.values()), progress).outcomes
    answers = {part: outcomes[task] for part, task in tasks.items()}
    for outcome in answers.values():
        if isinstance(outcome, InputError):
            raise outcome
    return answers


def make_part_task(name: str, part: str, blocks: Sequence[RandomStates]) -> PartTask:
    """The task of a function of the supplied equations at blocks of states."""
    given = dict(zip(ARGUMENTS, map(np.concatenate, zip(*blocks, strict=True)), strict=True))
    count, size = given["x"].shape
    given["t"] = np.linspace(0.0, 1.0, count)
    return PartTask(name, part, size, {argument: given[argument] for argument in TAKES[part]})


def make_blocks(part: str, states: RandomStates, sizes: RobotSizes) -> dict[Block, RandomStates]:
    """The states at which a part is asked, all blocks of them equally long."""
    blocks: dict[Block, RandomStates] = {HERE: states}
    blocks[AGAIN] = RandomStates(*(each[::-1] for each in states))
    if part in BY_RATES:
        for speed in SPEEDS:
            blocks[speed] = states._replace(v=speed * states.v, a=0 * states.a)
    if part == "inverse_dynamics":
        for joint in range(states.q.shape[1]):
            a = np.zeros_like(states.a)
            a[:, joint] = sizes.unit_accelerations[:, joint]
            blocks[joint,] = states._replace(v=0 * states.v, a=a)
    return blocks


def _derive_values(whole: Blocks, sizes: RobotSizes, weigh: bool) -> dict[str, np.ndarray]:
    """M, bias and, if inverse dynamics counts the weights, gravity: what follows from its answers.

    weigh: whether there are any to be counted.
    """
    rest, units = whole[0.0], sizes.unit_accelerations
    columns = [(whole[joint,] - rest) / units[:, joint, None] for joint in range(units.shape[1])]
    values = {"mass_matrix": np.stack(columns, axis=2), "bias": whole[1.0] - rest}
    weightless = weigh and bool((np.abs(rest) <= TOLERANCE * sizes.gravity).all())
    return values if weightless else values | {"gravity": rest}
