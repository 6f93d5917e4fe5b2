"""A planar chain of joints and links: its quantities, and its angles as rows over the coordinates.

The same functions serve symbols, for people and the errata finder, and exact fractions, for an
arm's numbers: a quantity is a sympy expression in the one case, a Fraction in the other. A row is
an angle's gradient over the coordinates q, shape (n,); every angle here is linear in q.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Any

import numpy as np

from crosscheck.analytic.derivation.stage import DirectStage, Stage, exact_fraction, stage_values
from crosscheck.analytic.paper.kinematics import gear_angles
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Coordinate, Layout, Meaning


@dataclass(frozen=True)
class Chain:
    """A planar chain: stages from the base on, payload [kg] at the last link's end, coordinates.

    Where the layout has no mesh displacements of a stage, its gears turn by pure rolling, without
    backlash.
    """

    stages: tuple[Stage | DirectStage, ...]
    payload: Any
    layout: Layout

    @property
    def numbers(self) -> range:
        """The joints, counted from 1."""
        return range(1, len(self.stages) + 1)

    @property
    def geared_joints(self) -> list[tuple[int, Stage]]:
        """The joints with gears, by number."""
        stages = zip(self.numbers, self.stages, strict=True)
        return [(joint, stage) for joint, stage in stages if isinstance(stage, Stage)]

    @cached_property
    def angles(self) -> list[np.ndarray]:
        """Rows of the bodies' absolute angles: the base, then link after link."""
        turns = [self.row("theta", joint) for joint in self.numbers]
        return list(accumulate(turns, initial=0 * turns[0]))

    def row(self, meaning: Meaning, joint: int, planet: int = 0) -> np.ndarray:
        """Row of a coordinate of a joint, of all its planets (0) or one; zeros if there is none."""
        row = np.zeros(len(self.layout), dtype=object)
        place = self.layout.places.get(Coordinate(meaning, joint, planet))
        if place is not None:
            row[place] = 1
        return row

    def sun_row(self, joint: int) -> np.ndarray:
        """Row of theta_s, relative to the ring's body (Eqs. 2, 3): by x_sp + x_pr, or x_s."""
        advance = self.row("x_s", joint) + self.row("x_sp", joint) + self.row("x_pr", joint, 0)
        return self._gear_rows(joint, advance, 0 * advance)[0]

    def planet_rows(self, joint: int) -> list[tuple[Any, np.ndarray]]:
        """Numbers of planets that turn together, with the rows of their theta_p (Eq. 3)."""
        stage = self.stages[joint - 1]
        assert isinstance(stage, Stage)
        planets = range(1, int(stage.N) + 1) if self.layout.free else ()
        groups = [(1, planet) for planet in planets] or [(stage.N, 0)]
        rows = [(count, self.row("x_pr", joint, planet)) for count, planet in groups]
        return [(count, self._gear_rows(joint, 0 * x_pr, x_pr)[1]) for count, x_pr in rows]

    def _gear_rows(
        self, joint: int, x_sp: np.ndarray, x_pr: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Rows of theta_s and theta_p."""
        stage, theta = self.stages[joint - 1], self.row("theta", joint)
        assert isinstance(stage, Stage)
        theta_s, theta_p = gear_angles(x_sp, x_pr, theta, stage.r_s, stage.r_p, stage.r_cp)
        return theta_s, theta_p

    def centre_of(self, joint: int) -> tuple[Any, ...]:
        """Lengths of the links before a joint, which say where its axis is."""
        return tuple(stage.L for stage in self.stages[: joint - 1])


def build_exact_chain(arm: Arm, layout: Layout) -> Chain:
    """The chain of an arm in fractions, equal to what its floating-point numbers are."""
    stages = [stage_values(j, link) for j, link in zip(arm.joints, arm.links, strict=True)]
    return Chain(tuple(stages), exact_fraction(arm.payload_mass_kg), layout)
