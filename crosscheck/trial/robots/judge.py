"""Equations of a robot beside its levels: which level they are of, and which entries differ."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import RandomStates, RobotSizes, compute_sizes
from crosscheck.findings import Finding
from crosscheck.models.errors import InputError
from crosscheck.models.robot.integration import conditioning_error
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import LEVELS, RIGID, Level, Robot
from crosscheck.registry import build_robot_model, find_level_engines
from crosscheck.report.formatting import join_words
from crosscheck.runner.outcomes import Failure, failure_from_error
from crosscheck.trial.changes.problem import ChangeProblem
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.judge import checks
from crosscheck.trial.judge.entries import (
    ALONE,
    EntryMismatch,
    LevelDistance,
    entry_place,
    format_entry,
    measure_distance,
    sort_distances,
)
from crosscheck.trial.result import TrialDiagnosis
from crosscheck.trial.robots.answers import NONLINEAR, RobotAnswers
from crosscheck.trial.robots.consistency import SlopeSides
from crosscheck.trial.robots.elastic import ELASTIC

RIGID_ROBOT = "the rigid robot"  # name of the only level of a robot without rotors
EARTH = 10.0  # m/s^2, of robots that stand in space
SINGLE = ("mass_matrix", "bias", "gravity")  # elementary parts, from which the others are composed


@dataclass(frozen=True)
class RobotProblem:
    """Equations of a robot, by name, and their answers at states.

    sizes: by level, of each that equations may be of; stated: the level that these are to be of;
    self_differences: by part, what it owes to the slopes of others; by_torques: by part, as in
    AnswerSet; lost: parts that did not answer where these were asked; friction
    (states, n): the torques that it takes, which those of the states are without; stiffness (n, n):
    of springs, whose torques stand beside the weights; equations: whose answers they are; motors:
    coordinates, from 0, that have one; is_mapped: whether the equations are in other coordinates;
    has_file_friction: whether the friction is that of the robot's file.
    """

    name: str
    robot: Robot
    states: RandomStates
    sizes: Mapping[Level, RobotSizes]
    answers: RobotAnswers
    stated: str
    self_differences: Mapping[str, SlopeSides] = field(default_factory=dict)
    by_torques: Mapping[str, np.ndarray] = field(default_factory=dict)
    lost: Mapping[str, Failure] = field(default_factory=dict)
    friction: np.ndarray = field(default_factory=lambda: np.zeros(1))
    stiffness: np.ndarray = field(default_factory=lambda: np.zeros((1, 1)))
    equations: Equations = field(default_factory=Equations)
    motors: tuple[int, ...] = ()
    is_mapped: bool = False
    has_file_friction: bool = False

    @property
    def mechanism(self) -> Robot:
        """The robot."""
        return self.robot

    @property
    def parts(self) -> tuple[str, ...]:
        """The quantities that the equations have answered, in the order of JUDGED."""
        return tuple(part for part in checks.JUDGED if part in self.answers.values)

    @property
    def names(self) -> list[str]:
        """Names of the coordinates: of the joints that move them."""
        return self.robot.coordinate_names

    def name_level(self, level: str) -> str:
        """The level as reports call it."""
        return ELASTIC if self.stiffness.any() else level

    @property
    def description(self) -> tuple[str, ...]:
        """Lines that describe the robot."""
        return tuple(repr(self.robot).splitlines())

    def describe_level(self, level: Level, distances: Sequence[LevelDistance]) -> tuple[str, str]:
        """The level with which equations are compared, and with which they agree, in words."""
        name, words = self.name_level(level), f"{level} ({LEVELS[level]})"
        equal = [each.level for each in distances if not each.entries]
        if name == ELASTIC:
            words = f"{name} (links, motors on the output side, and springs between them)"
        elif len(self.sizes) == 1 and not self.stated:
            return RIGID_ROBOT, RIGID_ROBOT
        elif not self.stated and len(equal) > 1:
            words = f"{join_words(equal)} (equal in these parts)"
        largest = next((each.largest for each in distances if each.level == level), 0.0)
        return name, f"{words} to {largest:.1e}"

    @cached_property
    def reference_values(self) -> dict[Level, Mapping[str, np.ndarray]]:
        """Values of each part by the project's own derivation, by level."""
        return {
            level: self.evaluate_model(AnalyticRobot(self.robot, level)) for level in self.sizes
        }

    def compare(self, level: Level) -> ChangeProblem:
        """The difference from a level, for the search of its causes."""
        sizes, parts = self.sizes[level], {*self.parts, "mass_matrix"}
        by_part = {part: sizes.entry_sizes(part) for part in parts - {"acceleration"}}
        return ChangeProblem(
            robot=self.robot,
            level=level,
            states=self.states._replace(torques=self.states.torques - self.spring_torques),
            values={part: self.answers.values[part] for part in self.parts},
            right=self.reference_values[level],
            sizes=by_part | {"acceleration": sizes.entry_sizes("balance")},
            tolerances={part: sizes.tolerance(part) for part in self.parts},
            is_weightless=self.answers.weightless,
            is_driven=self.answers.driven,
        )

    def are_alike(self, level: Level, other: Level) -> bool:
        """Whether two levels say the same of each part, as of a robot without rotors."""
        here, there = self.reference_values[level], self.reference_values[other]
        return all(np.array_equal(here[part], there[part]) for part in self.parts)

    def evaluate_model(self, model: RobotModel) -> dict[str, np.ndarray]:
        """Values of each part of the equations by a model, as the equations define them."""
        q, v, a, torques = self.states
        held, weights = self.spring_torques, self.spring_torques + model.gravity(q)
        meant = {
            "mass_matrix": lambda: model.mass_matrix(q),
            "bias": lambda: model.bias(q, v),
            "gravity": lambda: weights,
            "inverse_dynamics": lambda: (
                model.inverse_dynamics(q, v, a) + held - weights * self.answers.weightless
            ),
            "force": lambda: self.loads_in_force - self.weights_in_force(weights),
            "acceleration": lambda: model.forward_dynamics(q, v, torques - held),
        }
        return {part: meant[part]() for part in self.parts}

    @cached_property
    def spring_torques(self) -> np.ndarray:
        """Torques that hold the springs (states, n); 0 without springs."""
        q = self.states.q
        return q @ self.stiffness if self.stiffness.any() else 0 * q

    @property
    def loads_in_force(self) -> np.ndarray:
        """The motors' torques (states, n), less friction unless the bias has it."""
        taken = self.friction if self.answers.friction_in_bias else 0.0
        return self.states.torques + taken

    def weights_in_force(self, weights: np.ndarray) -> np.ndarray:
        """The weights (states, n), or 0 where force is the motors' torques alone."""
        return 0 * weights if self.answers.driven else weights

    def relative_errors(self, level: Level) -> dict[str, np.ndarray]:
        """By part, the differences from a level over their sizes (states, ...)."""
        sizes, answers, right = self.sizes[level], self.answers, self.reference_values[level]
        return {
            part: (answers.values[part] - right[part])
            / sizes.entry_sizes(part, answers.sources[part])
            for part in self.parts
        }

    def find_self_places(self, part: str, level: Level) -> list[tuple[int, ...]]:
        """The entries of a part that do not keep what the equations owe to themselves."""
        is_judged = part in self.self_differences
        return self._identify(part, self._size_parts(level)).places if is_judged else []

    def _size_parts(self, level: Level) -> dict[str, checks.PartSize]:
        sizes, sources = self.sizes[level], self.answers.sources
        return {part: checks.make_part_size(sizes, part, sources[part]) for part in self.parts}

    def _identify(self, part: str, sizes: Mapping[str, checks.PartSize]) -> checks.Identity:
        """What a part owes to slopes of answers."""
        sides, size = self.self_differences[part], sizes[part].scale_to_slopes()
        rows = size.entries[: len(sides[0])]
        if part == "bias":
            return checks.Identity(*checks.CHRISTOFFEL, size._replace(entries=rows), *sides)
        pairs = np.maximum(rows[:, :, None], rows[:, None, :])
        return checks.Identity(*checks.GRADIENT, size._replace(entries=pairs), *sides, axes=2)

    def collect_answers(self, level: Any) -> checks.AnswerSet:
        """The answers, to be judged by the sizes of a level."""
        answers, values = self.answers, {part: self.answers.values[part] for part in self.parts}
        sizes = self._size_parts(level)
        identities = [self._identify(part, sizes) for part in self.self_differences]
        if {"mass_matrix", "bias"} <= set(values):
            weights = values.get("gravity", 0.0)
            if "inverse_dynamics" in values:
                moving = np.einsum("sij,sj->si", values["mass_matrix"], self.states.a)
                expected = moving + values["bias"] + (0.0 if answers.weightless else weights)
                sides = values["inverse_dynamics"], expected
                identities.append(
                    checks.Identity(*checks.INVERSE, sizes["inverse_dynamics"], *sides)
                )
            if {"force", "acceleration"} <= set(values):
                size = sizes["acceleration"]._replace(entries=self.sizes[level].balance)
                force = values["force"] - (self.loads_in_force - self.states.torques)
                held = weights if answers.driven else 0.0
                identities.append(checks.make_second_law(size, values, held, force))
        return checks.AnswerSet(
            name=self.name,
            mechanism=self.robot.name,
            names=self.names,
            states=f"{len(self.states.q)} random states",
            values=values,
            sizes=sizes,
            symmetry=sizes.get("mass_matrix"),
            repeated=answers.again,
            failures={**self.lost, **answers.failures},
            other_speeds=answers.other_speeds,
            by_torques=self.by_torques,
            identities=identities,
        )

    def entries(self, level: Level) -> list[EntryMismatch]:
        """The entries that differ from a level by more than rounding, the largest share first."""
        wrong_entries = [
            entry
            for part, errors in self.relative_errors(level).items()
            for entry in self._find_wrong_entries(part, errors, self.sizes[level].tolerance(part))
        ]
        if not {entry.part for entry in wrong_entries}.isdisjoint(SINGLE):
            made = self.compare(level).list_consequences()
            wrong_entries = [replace(e, is_consequence=e.part in made) for e in wrong_entries]
        return sorted(wrong_entries, key=lambda entry: -entry.share)

    def _find_wrong_entries(
        self, part: str, relative_errors: np.ndarray, tolerance: float
    ) -> Iterator[EntryMismatch]:
        largest = np.abs(relative_errors).max(axis=0)
        for index in np.argwhere(~(largest <= tolerance)).tolist():
            place = tuple(index)
            mirrored = place[::-1]
            if place > mirrored and largest[mirrored] > tolerance:
                unlike = np.abs(
                    select_entry(relative_errors, place) - select_entry(relative_errors, mirrored)
                )
                if unlike.max() <= tolerance:
                    continue
            name, share = self.entry_name(part, place), float(largest[place])
            yield EntryMismatch(entry_place(part, place), share, name=name)

    def entry_name(self, part: str, place: Sequence[int]) -> str:
        """An entry in words, such as M[shoulder, elbow]."""
        return format_entry(entry_place(part, tuple(place)), self.names)

    def measure_levels(self) -> list[LevelDistance]:
        """How far the equations are from each level, the nearest first."""
        wrong = dict[LevelDistance, set[str]]()
        for level in self.sizes if self.parts else ():
            errors = self.relative_errors(level).values()
            largest = (np.abs(each).max(axis=0) for each in errors)
            entries = self.entries(level)
            distance = measure_distance(level, len(entries), largest)
            wrong[distance] = {entry.part for entry in entries}
        return sort_distances(wrong, self.stated) if wrong else []

    def judge_engines(self, answers: checks.AnswerSet, level: Any) -> Iterator[Finding]:
        """Every part compared with every engine; one that raises fails there."""
        for engine in find_level_engines(level):
            values: Mapping[str, np.ndarray | Failure]
            try:
                values = self.evaluate_model(build_robot_model(engine, self.robot, level))
            except Exception as error:  # whatever an engine raises is reported as a failure
                values = dict.fromkeys(self.parts, failure_from_error(error))
            yield from checks.judge_engine(answers, engine, values, answers.sizes)

    def measure_errors(self, level: Any) -> tuple[dict[str, np.ndarray], dict[str, float]]:
        """By part, the relative error of each entry from a level, and what is allowed."""
        sizes, errors = self.sizes[level], self.relative_errors(level)
        largest = {part: np.abs(off).max(axis=0) for part, off in errors.items()}
        return largest, {part: sizes.tolerance(part) for part in errors}

    def list_remarks(self) -> Iterator[str]:
        """Sentences on what was compared, and on how the equations were read."""
        answers = self.answers
        named = ", in which entries are named," * self.is_mapped
        yield f"compared in joint coordinates{named} on this robot {ALONE}"
        if answers.sources.get("bias") == NONLINEAR:
            nonlinear = "read as nonlinear effects, C v + g, of which g is its gravity"
            yield f"bias is not 0 at rest: {nonlinear}"
        if answers.driven and self.equations.gravity is None:
            yield "force has no weights: they are read as gravity, on the left"
        if answers.weightless:
            yield "inverse_dynamics leaves the weights out"
        if self.has_file_friction:
            yield "friction of the joints is that of the robot's file"

    def list_notes(self, diagnosis: TrialDiagnosis) -> Sequence[str]:
        """What of the robot's files is not used."""
        return self.robot.notes


def select_entry(values: np.ndarray, place: tuple[int, ...]) -> np.ndarray:
    """An entry of a part (states, ...) at all states, (states,)."""
    index: tuple[Any, ...] = (slice(None), *place)
    return values[index]


def compute_sizes_by_level(
    robot: Robot, stated: str, states: RandomStates
) -> dict[Level, RobotSizes]:
    """The sizes at each rigid level.

    Levels whose mass matrix is singular are left out. Raises InputError where none remains, or
    where the one that equations state is one of them.
    """
    sizes: dict[Level, RobotSizes] = {}
    for level in (each for each in RIGID if each in (*robot.levels, stated)):
        try:
            mass = AnalyticRobot(robot, level).mass_matrix(states.q)
            sizes[level] = compute_sizes(robot, mass, states, least_gravity=EARTH)
        except InputError:
            if level == stated:
                raise
    if not sizes:
        raise conditioning_error(robot)
    return sizes
