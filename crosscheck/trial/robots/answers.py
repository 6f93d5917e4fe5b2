"""What a user's equations of a robot answer at random states; their code runs in workers."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.answers import BadAnswer
from crosscheck.cost.agreement import TOLERANCE, DrawnStates, drawn
from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import Robot
from crosscheck.run import performed
from crosscheck.runner.outcomes import Failure, OwnKey
from crosscheck.runner.underway import Told
from crosscheck.runner.workers import Workers
from crosscheck.trial.input.calls import TAKES, by_name, part_answer, told_failure
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.robots.sizes import RobotSizes

STATES = 12
FASTEST = 2.0  # rad/s or m/s of a state, whatever the joint's limit: equations hold beyond it
CALL_S = 2e-3  # [s] that a user's Python takes over one answer, at most
LARGEST = 1e50  # of a number that can be compared
HERE, AGAIN = "here", "again"  # the states, and the same a second time in the other order
SPEEDS = (1.0, -1.0, 2.0, 0.0)  # at which the bias is asked, times each state's rates
BY_RATES = ("bias", "coriolis", "inverse_dynamics")  # parts that give the bias
Block = str | float | tuple[int]  # HERE, AGAIN, one of SPEEDS, or (joint,) that accelerates alone
Blocks = dict[Block, np.ndarray]  # answers of a function to each block of states
# The functions on trial, by the name of their equations: workers are forked and find them here.
_supplied: dict[str, Mapping[str, Any]] = {}
_one_at_a_time = threading.Lock()  # of trials in several threads, whose equations may share a name


@dataclass(frozen=True)
class PartCalls(OwnKey):
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
        call, answers = _supplied[self.model][self.quantity], list[np.ndarray]()
        try:
            for row in range(self.rows):
                own = {name: values[row] for name, values in self.arguments.items()}
                answer = part_answer(call, self.quantity, self.size, own)
                if not (np.abs(answer) <= LARGEST).all():
                    most = f"{LARGEST:g}, the most that can be compared"
                    raise BadAnswer(f"{self.quantity} is larger than {most}")
                answers.append(answer)
        except BadAnswer as error:
            if not answers:
                about = f"{error}; the coordinates are {self.size}"
                return InputError(self.model, "", None, about)
            return told_failure(error)
        except BaseException as error:  # also SystemExit and KeyboardInterrupt of the user's code
            return told_failure(error)
        return np.array(answers)


@dataclass(frozen=True)
class RobotAnswers:
    """What a user's equations say at the states, by quantity: M (states, n, n), others (states, n).

    again: the same, asked a second time in the other order. sources: the part that each comes from.
    speeds (states, 4, n): the bias at SPEEDS times the rates, None without a bias. failures: by
    part. weightless: whether inverse_dynamics is M a + bias and leaves the weights out.
    """

    values: Mapping[str, np.ndarray]
    again: Mapping[str, np.ndarray]
    sources: Mapping[str, str]
    speeds: np.ndarray | None
    failures: Mapping[str, Failure]
    weightless: bool


def states_of(robot: Robot, seed: int) -> DrawnStates:
    """The random states at which equations are asked."""
    states, rng = drawn(robot, STATES, seed), np.random.default_rng([seed, 1])
    return states._replace(v=rng.uniform(-FASTEST, FASTEST, states.v.shape))


@contextmanager
def supplied_as(name: str, equations: Equations) -> Iterator[None]:
    """Let workers that begin in this context call the functions of equations by a name."""
    given = {part: getattr(equations, part) for part in TAKES}
    functions = {
        part: by_name(own, part, in_order=True) for part, own in given.items() if own is not None
    }
    with _one_at_a_time:
        _supplied[name] = functions
        try:
            yield
        finally:
            del _supplied[name]


def ask(
    name: str, robot: Robot, states: DrawnStates, sizes: RobotSizes, jobs: int, told: Told
) -> RobotAnswers:
    """Ask all functions of the equations of a robot that are supplied under a name.

    Raises InputError for answers that can be none of this robot.
    """
    blocks = {part: _blocks(part, states, sizes) for part in _supplied[name]}
    outcomes = call({part: list(own.values()) for part, own in blocks.items()}, name, jobs, told)
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
    whole = answers.get("inverse_dynamics")
    values = {quantity: own[HERE] for quantity, own in answers.items()}
    derived = {} if whole is None else _derived(whole, sizes, _weigh(robot, states, sizes))
    sources = {quantity: quantity for quantity in values}
    sources |= {quantity: "inverse_dynamics" for quantity in derived if quantity not in values}
    if "coriolis" in outcomes and "bias" in values:
        sources["bias"] = "coriolis"
    by_rates = answers.get("bias", whole)
    speeds = None
    if by_rates is not None:
        rest = by_rates[0.0] if by_rates is whole else 0.0
        speeds = np.stack([by_rates[speed] - rest for speed in SPEEDS], axis=1)
    again = {quantity: own[AGAIN][::-1] for quantity, own in answers.items()}
    weightless = whole is not None and "gravity" not in derived
    return RobotAnswers(derived | values, again, sources, speeds, failures, weightless)


def call(
    asked: Mapping[str, Sequence[DrawnStates]], name: str, jobs: int, told: Told
) -> dict[str, np.ndarray | Failure]:
    """Call functions of the supplied equations at states, each by a worker; answers by part.

    Raises InputError for answers that can be none of this robot.
    """
    tasks = {part: _calls(name, part, states) for part, states in asked.items()}
    with Workers(min(jobs, len(tasks))) as workers:
        outcomes: Mapping[Any, Any] = performed(workers, list(tasks.values()), told).outcomes
    found = {part: outcomes[task] for part, task in tasks.items()}
    for outcome in found.values():
        if isinstance(outcome, InputError):
            raise outcome
    return found


def _calls(name: str, part: str, blocks: Sequence[DrawnStates]) -> PartCalls:
    q, v, a, torques = (np.concatenate(rows) for rows in zip(*blocks, strict=True))
    known = {"x": q, "v": v, "a": a, "torque": torques, "t": np.linspace(0.0, 1.0, len(q))}
    own = {argument: known[argument] for argument in TAKES[part]}
    return PartCalls(name, part, q.shape[1], own)


def _blocks(part: str, states: DrawnStates, sizes: RobotSizes) -> dict[Block, DrawnStates]:
    """The states at which a part is asked, all blocks of them equally long."""
    found: dict[Block, DrawnStates] = {HERE: states}
    found[AGAIN] = DrawnStates(*(each[::-1] for each in states))
    if part in BY_RATES:
        for speed in SPEEDS:
            found[speed] = states._replace(v=speed * states.v, a=0 * states.a)
    if part == "inverse_dynamics":
        for joint in range(states.q.shape[1]):
            a = np.zeros_like(states.a)
            a[:, joint] = sizes.unit_accelerations[:, joint]
            found[joint,] = states._replace(v=0 * states.v, a=a)
    return found


def _weigh(robot: Robot, states: DrawnStates, sizes: RobotSizes) -> bool:
    """Whether the weights of a robot need any torques."""
    weights = AnalyticRobot(robot, "links").gravity(states.q)
    return bool((np.abs(weights) > TOLERANCE * sizes.gravity).any())


def _derived(whole: Blocks, sizes: RobotSizes, weigh: bool) -> dict[str, np.ndarray]:
    """M, bias and, if inverse dynamics counts the weights, gravity: what follows from its answers.

    weigh: whether there are any to be counted.
    """
    rest, units = whole[0.0], sizes.unit_accelerations
    columns = [(whole[joint,] - rest) / units[:, joint, None] for joint in range(units.shape[1])]
    found = {"mass_matrix": np.stack(columns, axis=2), "bias": whole[1.0] - rest}
    weightless = weigh and bool((np.abs(rest) <= TOLERANCE * sizes.gravity).all())
    return found if weightless else found | {"gravity": rest}
