"""The states at which a trial asks equations, found by asking ones that take notes.

Nothing that a trial asks depends on an answer, so the notes are what any equations are asked, and
the number of a row stands for its state. Columns of answers are called the same in every file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Switches
from crosscheck.planning.comparison import ModelTask
from crosscheck.registry import register
from crosscheck.trial.coordinates.frame import Frame, build_frame
from crosscheck.trial.diagnose.diagnosis import PROBES
from crosscheck.trial.diagnose.probe import draw_probe_arms
from crosscheck.trial.diagnose.reasons import list_entry_quantities, list_entry_questions
from crosscheck.trial.input.calls import MATRICES, TAKES
from crosscheck.trial.input.equations import AnswerTable, Coordinates, Equations, Function, Level
from crosscheck.trial.judge.questions import VerificationProblem
from crosscheck.trial.model import make_registry_entry
from crosscheck.trial.trial import TrialRequest, build_problem, list_tasks

PARTS = ("mass_matrix", "bias", "force", "acceleration", "inverse_dynamics")
INVERSE_DYNAMICS = "inverse_dynamics"  # it is asked at states of its own, with accelerations
MOST_COORDINATES = 12  # coordinates: beyond that inverse dynamics takes a million rows
# One who has M, bias and force is asked for an acceleration nowhere else than one who has it.
ALIKE = (PARTS[:3], PARTS[:4])
USUAL = Coordinates()
ARGUMENTS = ("t", "x", "v", "torque", "a")
ROW = "row"
# What a part is called in files.
SHORT = {part: part for part in PARTS} | {"mass_matrix": "M"}
# 1 in a row where a trial looks the part up, 0 where it may be left out.
NEEDED = tuple(f"for_{short}" for short in SHORT.values())
# What an argument is called in files, and the rest of its unit.
LETTERS = {"x": "q", "v": "v", "a": "a"}
PER_TIME = {"x": "", "v": "_per_s", "a": "_per_s2"}


class Call(NamedTuple):
    """A part, asked for the first time or again; its arguments as TAKES has them, in a row."""

    part: str
    again: bool
    arguments: tuple[float, ...]


@dataclass(frozen=True)
class TableTrial:
    """A trial of answers: arm, coordinates and level of the equations, laws, how many states."""

    arm: Arm
    coordinates: Coordinates = USUAL
    level: Level = ""
    chosen: Switches | None = None
    quick: bool = False
    seed: int = 0

    def make_request(self, name: str, equations: Equations) -> TrialRequest:
        """What a trial of these equations is asked for."""
        return TrialRequest(
            name, equations, self.arm, chosen=self.chosen, quick=self.quick, seed=self.seed
        )

    def equations(self, parts: Iterable[str], answer: Answer) -> Equations:
        """Equations whose parts are what ``answer`` gives for a Call."""
        made = []
        for again in (False, True):
            functions: dict[str, Any] = {part: _function(part, again, answer) for part in parts}
            made.append(Equations(coordinates=self.coordinates, level=self.level, **functions))
        first, second = made
        return replace(first, table=AnswerTable(second))


Answer = Callable[[Call], np.ndarray]


def _function(part: str, again: bool, answer: Answer) -> Function:
    return lambda *arguments: answer(make_call(part, again, *arguments))


@dataclass(frozen=True, eq=False)
class StateRequest:
    """The rows of what is asked on one arm, numbered from ``first`` on.

    arguments: t [s] (rows, 1), x, v, a (rows, n) in the user's coordinates, torque (rows, joints)
    [N m] on the output side; 0 where no part of a row takes one. needed (rows,) by part: where it
    is looked up. row_of: of every call. at (states,) by part: rows of the trial's random states.
    """

    arm: Arm
    frame: Frame
    first: int
    arguments: Mapping[str, np.ndarray]
    needed: Mapping[str, np.ndarray]
    row_of: Mapping[Call, int]
    at: Mapping[str, np.ndarray]

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
        n = len(self.frame.names)
        return (n, n) if part in MATRICES else (n,)


def collect_state_request(trial: TableTrial) -> StateRequest:
    """The states at which M, bias, force and acceleration are asked. Raises InputError."""
    return _collect_request(trial, ALIKE, 1)


def collect_inverse_requests(trial: TableTrial, states: StateRequest) -> tuple[StateRequest, ...]:
    """The states at which inverse dynamics is asked, in rows after these.

    There are none for many coordinates. Raises InputError.
    """
    if len(states.frame.names) > MOST_COORDINATES:
        return ()
    return (_collect_request(trial, ((INVERSE_DYNAMICS,),), states.first + states.count),)


def _collect_request(
    trial: TableTrial, supplied: Iterable[Sequence[str]], first: int
) -> StateRequest:
    notes: dict[Call, None] = {}
    for parts in supplied:
        request, problem = _record_calls(trial, parts, notes)
        _perform(problem, list_tasks(problem, [], request))
    return _build_request(problem, notes, first)


def collect_probe_requests(
    trial: TableTrial, parts: Sequence[str], first: int
) -> list[StateRequest]:
    """States at which parts are asked on arms whose numbers hide nothing; first: a row's number.

    Raises InputError where there is no such arm.
    """
    requests = []
    for arm in draw_probe_arms(trial.arm, PROBES):
        notes: dict[Call, None] = {}
        probe = _record_calls(trial, parts, notes)[1].adapt_to_arm(arm)
        _perform(probe, list_entry_questions(probe, probe.levels, list_entry_quantities(probe)))
        requests.append(_build_request(probe, notes, first))
        first += requests[-1].count
    return requests


def _record_calls(
    trial: TableTrial, parts: Sequence[str], notes: dict[Call, None]
) -> tuple[TrialRequest, VerificationProblem]:
    """Supplied equations that note what they are asked, and answer with nothing but inertia."""
    size = len(build_frame(trial.coordinates, trial.arm).names)

    def answer(call: Call) -> np.ndarray:
        notes[call] = None
        if call.part == INVERSE_DYNAMICS:
            return np.array(call.arguments[2 * size :])
        return np.eye(size) if call.part in MATRICES else np.zeros(size)

    request = trial.make_request("what is asked", trial.equations(parts, answer))
    return request, build_problem(request)


def _perform(problem: VerificationProblem, tasks: Iterable[ModelTask]) -> None:
    """Perform the tasks on the equations; what they call is noted."""
    with register(problem.name, make_registry_entry(problem.name, problem.equations, problem.has)):
        for task in tasks:
            if task.model == problem.name:
                task.perform()


def _build_request(problem: VerificationProblem, notes: Iterable[Call], first: int) -> StateRequest:
    """The states of all calls, numbered from `first` on.

    A call that takes fewer arguments stands in the row of one that takes the same and more.
    """
    sizes = {"t": 1, "torque": len(problem.case.arm.joints)}
    sizes = {name: sizes.get(name, len(problem.frame.names)) for name in ARGUMENTS}
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
            for fewer in {TAKES[part] for part in PARTS if set(TAKES[part]) <= set(takes)}:
                argument_values = tuple(value for name in fewer for value in row[name])
                places.setdefault(("".join(fewer), call.again, argument_values), len(rows))
            rows.append(row)
        row_of[call] = places[key]
    arguments = {
        name: np.array([row.get(name, (0.0,) * size) for row in rows]).reshape(len(rows), size)
        for name, size in sizes.items()
    }
    needed = {part: np.zeros(len(rows), dtype=bool) for part in PARTS}
    for call, place in row_of.items():
        needed[call.part][place] = True
    # Rows of the trial's own states, -1 where a part is not asked at them.
    states = [{"t": s.t, "x": s.x, "v": s.u, "torque": s.torque} for s in problem.states]
    at = {}
    for part in PARTS[:4]:
        calls = (make_call(part, False, *(state[name] for name in TAKES[part])) for state in states)
        at[part] = np.array([row_of.get(call, -1) for call in calls])
    return StateRequest(problem.case.arm, problem.frame, first, arguments, needed, row_of, at)


def make_call(part: str, again: bool, *arguments: Any) -> Call:
    """The call of a part with arguments in the order of TAKES."""
    return Call(part, again, tuple(np.hstack(arguments).tolist()))


def argument_columns(frame: Frame, coordinates: Coordinates, arm: Arm) -> dict[str, list[str]]:
    """Names of the columns of every argument, with units at their ends.

    Coordinates of a matrix have no units.
    """
    units = _units(frame, coordinates)
    columns = {"t": ["t_s"]}
    for argument, letter in LETTERS.items():
        columns[argument] = [
            f"{letter}_{name}" + (f"_{unit}{PER_TIME[argument]}" if unit else "")
            for name, unit in zip(frame.names, units, strict=True)
        ]
    joints = range(1, len(arm.joints) + 1)
    return {**columns, "torque": [f"torque_{joint}_N_m" for joint in joints]}


def _units(frame: Frame, coordinates: Coordinates) -> list[str]:
    if coordinates.matrix is not None:
        return [""] * len(frame.names)
    if coordinates.gears == "angles":
        return ["rad"] * len(frame.names)
    usual = {c.name: "rad" if c.is_angle else "m" for c in frame.layout.coordinates}
    ordered = coordinates.order or tuple(usual)
    return [usual.get(name, "rad") for name in ordered]


def answer_columns(part: str, n: int) -> list[str]:
    """Names of the columns of a part's answers, row by row of a matrix."""
    if part in MATRICES:
        return [f"{SHORT[part]}_{i}_{j}" for i in range(1, n + 1) for j in range(1, n + 1)]
    return [f"{SHORT[part]}_{i}" for i in range(1, n + 1)]
