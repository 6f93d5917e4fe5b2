"""A difference between equations and a mechanism's level, whichever judge has found it.

All its parts are laid out in one row of places, over their sizes, beside which the effect of every
change is laid out alike.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot, multiply
from crosscheck.checks.robot_states import RandomStates
from crosscheck.models.robot.robot import Level, Robot

# What an explanation may leave of each entry's largest difference; and of its size, by rounding.
LEFT, ROUNDING = 1e-5, 1e-12
ACCELERATION = "acceleration"
Places = np.ndarray | slice  # of a row
Entry = tuple[int, ...]  # row, or row and column, of an entry


class DynamicsTerms(NamedTuple):
    """M (states, n, n), bias and gravity (states, n), of a robot or of one of its bodies."""

    mass_matrix: np.ndarray
    bias: np.ndarray
    gravity: np.ndarray

    def minus(self, other: DynamicsTerms) -> DynamicsTerms:
        """The differences from other terms."""
        return DynamicsTerms(*(left - right for left, right in zip(self, other, strict=True)))


@dataclass(frozen=True)
class ChangeProblem:
    """What a change of a mechanism must explain.

    Args:
        robot: The mechanism, without friction.
        level: Whose terms the equations are compared with.
        states: Coordinates, rates, accelerations, torques less those that hold springs.
        values: By part, what the equations answered, (states, n, n) of mass_matrix, else
            (states, n): of bias, gravity, inverse_dynamics, force (of motors, less weights unless
            is_driven) and acceleration.
        right: The same of the level.
        sizes: Natural size of each entry by part, alike, and of mass_matrix in any case; of
            acceleration that of its balance, M a + bias + gravity - torques.
        tolerances: By part, of an entry of right equations, relative to its size.
        is_weightless: Whether inverse_dynamics is without gravity.
        is_driven: Whether force is the motors' torques alone.
        turns: dq/dx (n, n) where values and sizes are those of other coordinates x.
    """

    robot: Robot
    level: Level
    states: RandomStates
    values: Mapping[str, np.ndarray]
    right: Mapping[str, np.ndarray]
    sizes: Mapping[str, np.ndarray]
    tolerances: Mapping[str, float]
    is_weightless: bool = False
    is_driven: bool = False
    turns: np.ndarray | None = None

    @property
    def parts(self) -> list[str]:
        """The parts that there are, in the order of a row."""
        return list(self.values)

    @cached_property
    def differences(self) -> dict[str, np.ndarray]:
        """By part, the equations' values less the right ones."""
        return {part: values - self.right[part] for part, values in self.values.items()}

    def carry(self, part: str, values: np.ndarray) -> np.ndarray:
        """Values of a part (..., n), or of M (..., n, n), from the joints' own coordinates."""
        if self.turns is None:
            return values
        values = values @ self.turns
        return self.turns.T @ values if part == "mass_matrix" else values

    def lay_out(self, change: DynamicsTerms, states: slice = slice(None)) -> np.ndarray:
        """Changes of all parts, in one row (..., places), that follow from those of the terms.

        Accelerations are held in the balance that they make, on which numbers act by at most
        their square as well.
        """
        mass, bias, gravity = (self.carry(*each) for each in change._asdict().items())
        held, values = bias + gravity, self.values
        made = {
            "mass_matrix": mass,
            "bias": bias,
            "gravity": gravity,
            "force": 0 * gravity if self.is_driven else -gravity,
        }
        if "inverse_dynamics" in values:
            whole = bias if self.is_weightless else held
            made["inverse_dynamics"] = multiply(mass, self.states.a[states]) + whole
        if ACCELERATION in values:
            made[ACCELERATION] = multiply(mass, values[ACCELERATION][states]) + held
        return self._join(made, states)

    @cached_property
    def difference(self) -> np.ndarray:
        """The differences in one row (places,)."""
        parts = dict(self.differences)
        if ACCELERATION in parts:
            mass = AnalyticRobot(self.robot, self.level).mass_matrix(self.states.q)
            mass = self.carry("mass_matrix", mass)
            parts[ACCELERATION] = -multiply(mass, parts[ACCELERATION])
        return self._join(parts, slice(None))

    @cached_property
    def allowed(self) -> np.ndarray:
        """Largest residual that an explanation may have at each place of a row.

        An entry's own difference decides, so that a large one elsewhere hides nothing here; one
        that is right may stay as wrong as right ones are.
        """
        allowed = np.empty_like(self.difference)
        views = self._split(allowed)
        for part, wrong in self._split(self.difference).items():
            largest, tolerance = np.abs(wrong).max(axis=0), self.tolerances[part]
            rounding = np.where(largest <= tolerance, max(tolerance, ROUNDING), ROUNDING)
            least = np.maximum(tolerance if part == ACCELERATION else rounding, LEFT * largest)
            views[part][:] = least
        return allowed

    def can_explain(self, change: np.ndarray, places: Places = slice(None)) -> bool:
        """Whether a change of the row explains the difference at some places of it."""
        left = np.abs(self.difference[places] - change[places])
        return bool((left <= self.allowed[places]).all())

    def list_consequences(self) -> list[str]:
        """The parts whose differences are what those of M, bias and gravity make."""
        row, parts = 0 * self.states.q, DynamicsTerms._fields
        zeros = DynamicsTerms(row[:, :, None] * row[:, None], row, row)
        differences = {part: self.differences[part] for part in parts if part in self.differences}
        made = self.lay_out(zeros._replace(**differences))
        others = [part for part in self.parts if part not in parts]
        return [part for part in others if self.can_explain(made, self.select_part(part))]

    def select_part(self, part: str) -> np.ndarray:
        """Mask of the places of a row in a part."""
        mask = np.zeros(self.difference.size, bool)
        self._split(mask)[part][:] = True
        return mask

    def select_entries(self, part: str, entries: Collection[Entry]) -> np.ndarray:
        """Mask of the places of a row in some entries of a part and in their mirror images."""
        mask = np.zeros(self.difference.size, bool)
        entries_first = np.moveaxis(self._split(mask)[part], 0, -1)
        for entry in entries:
            entries_first[entry] = entries_first[entry[::-1]] = True
        return mask

    def list_places(self, states: slice) -> np.ndarray:
        """The places of a row at some states."""
        parts = self._split(np.arange(self.difference.size))
        return np.concatenate([places[states].ravel() for places in parts.values()])

    def select_screened(self, places: Places, states: slice) -> tuple[np.ndarray, np.ndarray]:
        """The places of a row at some states that are among some, and which of all there."""
        at = self.list_places(states)
        chosen = np.isin(at, np.arange(self.difference.size)[places])
        return at[chosen], chosen

    def _split(self, row: np.ndarray) -> dict[str, np.ndarray]:
        """The parts (states, ...) of a row, as views."""
        views, end = dict[str, np.ndarray](), 0
        for part, wrong in self.differences.items():
            end += wrong.size
            views[part] = row[end - wrong.size : end].reshape(wrong.shape)
        return views

    def _join(self, parts: Mapping[str, np.ndarray], states: slice) -> np.ndarray:
        rows = []
        for part in self.parts:
            wrong = parts[part] / self.sizes[part][states]
            axes = 3 if part == "mass_matrix" else 2
            rows.append(wrong.reshape(*wrong.shape[: wrong.ndim - axes], -1))
        return np.concatenate(rows, axis=-1)
