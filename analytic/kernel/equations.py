"""A model's equations as a kernel runs them: structure, numbers, and the kernel's coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from crosscheck.analytic.derivation.gears import Gears
from crosscheck.analytic.derivation.terms import Terms, mass_matrices
from crosscheck.analytic.kernel.batch import SteppedEquations
from crosscheck.analytic.kernel.links import Links
from crosscheck.analytic.kernel.numbers import Numbers, link_numbers, term_numbers
from crosscheck.analytic.kernel.program import RecordMap
from crosscheck.analytic.kernel.text.links import LinkStructure, build_link_structure
from crosscheck.analytic.kernel.text.terms import TermStructure, build_term_structure
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import MESHES, Layout
from crosscheck.models.experiment.drive import DriveData


@dataclass(frozen=True)
class TermEquations(SteppedEquations):
    """Equations of a model in the layout's own coordinates, from terms."""

    arm: Arm
    layout: Layout
    gears: Gears
    drive: DriveData
    terms: Terms

    @cached_property
    def structure(self) -> TermStructure:
        """Structure of the terms, which the kernel's text depends on."""
        return build_term_structure(self.layout, self.gears, self.drive, self.terms)

    @cached_property
    def numbers(self) -> Numbers:
        """The numbers that terms and meshes need, by name."""
        return term_numbers(self.arm, self.structure, self.terms, self.gears, self.drive)

    def kinetic_energy(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Kinetic energy v^T M v / 2 (records,) [J] at states q, v (records, n) of the layout."""
        return np.einsum("ki,kij,kj->k", v, mass_matrices(self.terms, q), v) / 2


@dataclass(frozen=True)
class LinkEquations(SteppedEquations):
    """Equations of an arm's own bodies over its links, each gear's own spin eliminated."""

    arm: Arm
    layout: Layout
    gears: Gears
    drive: DriveData
    links: Links

    @cached_property
    def structure(self) -> LinkStructure:
        """Structure of the links, which the kernel's text depends on."""
        return build_link_structure(self.arm, self.layout, self.gears, self.drive, self.links)

    @cached_property
    def numbers(self) -> Numbers:
        """Numbers of links, gears and meshes, by name."""
        return link_numbers(self.arm, self.structure, self.links, self.gears, self.drive)

    def record_map(self) -> RecordMap:
        """The layout's coordinates by the kernel's: lumped, x_sp is the sun's advance less x_pr."""
        entries: list[tuple[int, ...]] = [(place,) for place in range(len(self.layout))]
        if self.layout.free:
            return tuple(entries)
        for place, joint in enumerate(self.layout.mesh_joints):
            entries[self.layout.at("x_sp", joint)] = (2 * place, 2 * place + 1)
            entries[self.layout.at("x_pr", joint)] = (2 * place + 1,)
        for place, at in enumerate(self.layout.theta, 2 * len(self.layout.mesh_joints)):
            entries[at] = (place,)
        return tuple(entries)

    def to_kernel(self, x: np.ndarray) -> np.ndarray:
        """Coordinates or rates x (..., n) as the kernel's: the sun's advance, planets, angles."""
        if self.layout.free:
            return x
        x_sp, x_pr = (x[..., self.layout.indices(mesh)] for mesh in MESHES)
        gears = np.stack([x_sp + x_pr, x_pr], axis=-1).reshape(*x.shape[:-1], 2 * x_sp.shape[-1])
        return np.concatenate([gears, x[..., self.layout.theta]], axis=-1)

    def kinetic_energy(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Kinetic energy (records,) [J] at states q, v (records, n) of the layout.

        The links' is summed pair by pair: no more numbers are at hand than the records have.
        """
        x, rates, links = self.to_kernel(q), self.to_kernel(v), self.links
        joints = len(self.structure.stages)
        # Absolute angles and rates of the links (joints, records).
        turned, turning = (np.cumsum(each.T[-joints:], axis=0) for each in (x, rates))
        inertia = (links.coupling + links.constant).diagonal()
        energy: np.ndarray = (inertia[:, None] * turning**2).sum(axis=0) / 2
        for k, before in combinations(range(joints), 2):
            between = links.coupling[k, before] * np.cos(turned[k] - turned[before])
            energy += (between + links.constant[k, before]) * turning[k] * turning[before]
        place, first = 0, len(self.structure.coordinates) - joints
        for j, stage in self.structure.geared_joints:
            base = turning[j - 2] if j > 1 else 0.0
            for gear in ["s"] + ["p"] * stage.planets:
                per, u, kappa = (
                    self.numbers[f"{name}_{gear}{j}"] for name in ("inv", "u", "kappa")
                )
                # J (a x' + base + rho theta')^2 with u = 1 / a, kappa = rho / a, inv = 1 / (J a^2)
                rate = rates[:, place] + u * base + kappa * rates[:, first + j - 1]
                energy += rate**2 / (2 * per)
                place += 1
        return energy


KernelEquations = TermEquations | LinkEquations
