"""The states at which a trial asks equations, found by asking ones that take notes.

Nothing that a trial asks depends on an answer, so the notes are what any equations are asked, and
the number of a row stands for its state. Columns of answers are called the same in every file.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any, ClassVar, NamedTuple

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Switches
from crosscheck.planning.comparison import ModelTask
from crosscheck.registry import register
from crosscheck.trial.arms.model import make_registry_entry
from crosscheck.trial.arms.questions import VerificationProblem
from crosscheck.trial.arms.subject import build_problem, list_tasks
from crosscheck.trial.changes.arms.arm_numbers import draw_probe_arms
from crosscheck.trial.changes.arms.causes import PROBES
from crosscheck.trial.changes.arms.comparison import list_entry_questions
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.input.calls import MATRICES, TAKES
from crosscheck.trial.input.equations import AnswerTable, Coordinates, Equations, Function, Level
from crosscheck.trial.request import TrialRequest

PARTS = ("mass_matrix", "bias", "gravity", "force", "acceleration", "inverse_dynamics")
INVERSE_DYNAMICS = "inverse_dynamics"  # it is asked at states of its own, with accelerations
MOST_COORDINATES = 12  # coordinates: beyond that inverse dynamics takes a million rows
# One who has M, bias and force is asked for an acceleration nowhere else than one who has it.
ALIKE = (PARTS[:4], PARTS[:5])
USUAL = Coordinates()
ARGUMENTS = ("t", "x", "v", "torque", "a")
ROW = "row"
# What a part is called in files.
SHORT = {part: part for part in TAKES} | {"mass_matrix": "M"}
# What an argument is called in files, and the rest of its unit.
LETTERS = {"x": "q", "v": "v", "a": "a"}
PER_TIME = {"x": "", "v": "_per_s", "a": "_per_s2"}


class Call(NamedTuple):
    """A part, asked for the first time or again; its arguments as TAKES has them, in a row."""

    part: str
    again: bool
    arguments: tuple[float, ...]


@dataclass(frozen=True)
class AnsweredTrial(ABC):
    """A trial of answers: mechanism, coordinates, level, laws, how many states, and their seed.

    parts: that may be answered; usual: groups of parts that are asked together, inverse dynamics
    apart; most_coordinates: up to which that is asked; least_digits: that answers must have.
    """

    mechanism: Any
    coordinates: Coordinates = USUAL
    level: Level = ""
    switches: Switches | None = None
    quick: bool = False
    seed: int = 0
    parts: ClassVar[tuple[str, ...]] = PARTS
    usual: ClassVar[tuple[tuple[str, ...], ...]]
    most_coordinates: ClassVar[float]
    least_digits: ClassVar[int]

    def make_request(self, name: str, equations: Equations) -> TrialRequest:
        """Request for a trial of these equations."""
        given = name, equations, self.mechanism
        return TrialRequest(*given, switches=self.switches, quick=self.quick, seed=self.seed)

    @abstractmethod
    def collect_request(self, groups: Iterable[Sequence[str]], first: int) -> StateRequest:
        """The states at which groups of parts are asked, in rows from ``first`` on.

        Raises InputError.
        """

    def collect_probe_requests(self, parts: Sequence[str], first: int) -> list[StateRequest]:
        """States at which parts are asked with numbers that hide nothing; none by default."""
        return []

    def equations(self, parts: Iterable[str], answer: Answer) -> Equations:
        """Equations whose parts are what ``answer`` gives for a Call."""
        made = []
        for again in (False, True):
            functions: dict[str, Any] = {
                part: _make_function(part, again, answer) for part in parts
            }
            made.append(Equations(coordinates=self.coordinates, level=self.level, **functions))
        first, second = made
        return replace(first, table=AnswerTable(second))

    def record_equations(
        self, parts: Sequence[str], size: int, notes: dict[Call, None]
    ) -> Equations:
        """Equations that note what they are asked, and answer with nothing but inertia."""

        def answer(call: Call) -> np.ndarray:
            notes[call] = None
            if call.part == INVERSE_DYNAMICS:
                return np.array(call.arguments[2 * size :])
            return np.eye(size) if call.part in MATRICES else np.zeros(size)

        return self.equations(parts, answer)


class TableTrial(AnsweredTrial):
    """A trial of an arm's answers."""

    usual = ALIKE
    most_coordinates = MOST_COORDINATES
    least_digits = 7

    def collect_request(self, groups: Iterable[Sequence[str]], first: int) -> StateRequest:
        """The states at which groups of parts are asked. Raises InputError."""
        notes: dict[Call, None] = {}
        for parts in groups:
            request, problem = self._record_calls(parts, notes)
            _perform(problem, list_tasks(problem, [], request))
        return self._build_request(problem, notes, first)

    def collect_probe_requests(self, parts: Sequence[str], first: int) -> list[StateRequest]:
        """States at which parts are asked on arms whose numbers hide nothing.

        Raises InputError where there is no such arm.
        """
        requests = []
        for arm in draw_probe_arms(self.mechanism, PROBES, {}):
            notes: dict[Call, None] = {}
            probe = self._record_calls(parts, notes)[1].adapt_to_arm(arm)
            _perform(probe, list_entry_questions(probe))
            requests.append(self._build_request(probe, notes, first))
            first += requests[-1].count
        return requests

    def _record_calls(
        self, parts: Sequence[str], notes: dict[Call, None]
    ) -> tuple[TrialRequest, VerificationProblem]:
        size = len(build_frame(self.coordinates, self.mechanism).names)
        request = self.make_request("what is asked", self.record_equations(parts, size, notes))
        return request, build_problem(request)

    def _build_request(
        self, problem: VerificationProblem, notes: Iterable[Call], first: int
    ) -> StateRequest:
        """Request for the recorded calls."""
        arm = problem.case.arm
        columns = argument_columns(problem.frame, self.coordinates, arm)
        return build_request(arm, problem.frame.names, columns, self.parts, notes, first)


Answer = Callable[[Call], np.ndarray]


def _make_function(part: str, again: bool, answer: Answer) -> Function:
    """The function of a part, its arguments in the order of TAKES."""
    return lambda *given: answer(Call(part, again, tuple(np.hstack(given).tolist())))


@dataclass(frozen=True, eq=False)
class StateRequest:
    """The rows of what is asked on one arm or robot, numbered from ``first`` on.

    names: of the coordinates; columns: names of the columns of every argument, with units.

    arguments: t [s] (rows, 1), x, v, a (rows, n) in the user's coordinates, torque (rows, joints)
    [N m] on the output side; 0 where no part of a row takes one. needed (rows,) by part: where it
    is looked up. row_of: of every call.
    """

    arm: Any
    names: Sequence[str]
    columns: Mapping[str, Sequence[str]]
    first: int
    arguments: Mapping[str, np.ndarray]
    needed: Mapping[str, np.ndarray]
    row_of: Mapping[Call, int]

    @property
    def count(self) -> int:
        """How many rows there are."""
        return len(self.arguments["t"])

    @property
    def inverse_dynamics_rows(self) -> np.ndarray:
        """Which rows (rows,) are of inverse dynamics."""
        return self.needed[INVERSE_DYNAMICS]

    def shape(self, part: str) -> tuple[int, ...]:
        """The shape of a part's answer: (n, n) of a matrix, else (n,)."""
        n = len(self.names)
        return (n, n) if part in MATRICES else (n,)


def collect_state_request(trial: AnsweredTrial) -> StateRequest:
    """The states at which all parts but inverse dynamics are asked. Raises InputError."""
    return trial.collect_request(trial.usual, 1)


def collect_inverse_requests(
    trial: AnsweredTrial, states: StateRequest
) -> tuple[StateRequest, ...]:
    """The states at which inverse dynamics is asked, in rows after these.

    There are none for many coordinates. Raises InputError.
    """
    if len(states.names) > trial.most_coordinates:
        return ()
    return (trial.collect_request(((INVERSE_DYNAMICS,),), states.first + states.count),)


def _perform(problem: VerificationProblem, tasks: Iterable[ModelTask]) -> None:
    """Perform the tasks on the equations; what they call is noted."""
    with register(problem.name, make_registry_entry(problem.name, problem.equations, problem.has)):
        for task in tasks:
            if task.model == problem.name:
                task.perform()


def build_request(
    arm: Any,
    names: Sequence[str],
    columns: Mapping[str, Sequence[str]],
    parts: Sequence[str],
    notes: Iterable[Call],
    first: int,
) -> StateRequest:
    """The states of all calls, numbered from `first` on.

    A call that takes fewer arguments stands in the row of one that takes the same and more.
    """
    sizes = {name: len(columns[name]) for name in ARGUMENTS}
    rows: list[dict[str, tuple[float, ...]]] = []
    places: dict[tuple[str, bool, tuple[float, ...]], int] = {}
    row_of: dict[Call, int] = {}
    for call in sorted(
        notes, key=lambda each: (each.part == INVERSE_DYNAMICS, each.again, -len(TAKES[each.part]))
    ):
        takes = TAKES[call.part]
        key = ("".join(takes), call.again, call.arguments)
        if key not in places:
            values = iter(call.arguments)
            row = {name: tuple(islice(values, sizes[name])) for name in takes}
            for fewer in {TAKES[part] for part in parts if set(TAKES[part]) <= set(takes)}:
                argument_values = tuple(value for name in fewer for value in row[name])
                places.setdefault(("".join(fewer), call.again, argument_values), len(rows))
            rows.append(row)
        row_of[call] = places[key]
    arguments = {
        name: np.array([row.get(name, (0.0,) * size) for row in rows]).reshape(len(rows), size)
        for name, size in sizes.items()
    }
    needed = {part: np.zeros(len(rows), dtype=bool) for part in parts}
    for call, place in row_of.items():
        needed[call.part][place] = True
    return StateRequest(arm, names, columns, first, arguments, needed, row_of)


def flag_column(part: str) -> str:
    """The column that is 1 where a trial looks the part up, 0 where it may be left out."""
    return f"for_{SHORT[part]}"


def argument_columns(frame: Frame, coordinates: Coordinates, arm: Arm) -> dict[str, Sequence[str]]:
    """Names of the columns of every argument, with units at their ends.

    Coordinates of a matrix have no units.
    """
    joints = range(1, len(arm.joints) + 1)
    torque = [f"torque_{joint}_N_m" for joint in joints]
    return name_columns(frame.names, _units(frame, coordinates), torque)


def name_columns(
    names: Sequence[str], units: Sequence[str], torque: Sequence[str]
) -> dict[str, Sequence[str]]:
    """Names of the columns of every argument, of coordinates with these names and units."""
    columns: dict[str, Sequence[str]] = {"t": ["t_s"]}
    for argument, letter in LETTERS.items():
        columns[argument] = [
            f"{letter}_{name}" + (f"_{unit}{PER_TIME[argument]}" if unit else "")
            for name, unit in zip(names, units, strict=True)
        ]
    return {**columns, "torque": torque}


def _units(frame: Frame, coordinates: Coordinates) -> list[str]:
    if coordinates.matrix is not None:
        return [""] * len(frame.names)
    if coordinates.gears == "angles":
        return ["rad"] * len(frame.names)
    usual = {c.name: "rad" if c.is_angle else "m" for c in frame.layout.coordinates}
    ordered = coordinates.order or tuple(usual)
    return [usual.get(name, "rad") for name in ordered]


def answer_columns(part: str, n: int) -> list[str]:
    """Column names of a part's answers; a matrix goes row by row."""
    if part in MATRICES:
        return [f"{SHORT[part]}_{i}_{j}" for i in range(1, n + 1) for j in range(1, n + 1)]
    return [f"{SHORT[part]}_{i}" for i in range(1, n + 1)]
