"""Kinetic energy along recorded states, of a member of a batch."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from crosscheck.analytic.kernel.links import Links
from crosscheck.analytic.kernel.numbers import Numbers
from crosscheck.analytic.kernel.structure import Structure


def kinetic_energy(
    structure: Structure, links: Links, numbers: Numbers, x: np.ndarray, v: np.ndarray
) -> np.ndarray:
    """(records,) [J], of coordinates x and rates v (records, n) in the structure's order."""
    joints = len(structure.stages)
    turned, turning = (np.cumsum(each.T[-joints:], axis=0) for each in (x, v))
    energy = _of_links(links, turned, turning)
    place, first = 0, len(structure.coordinates) - joints
    for j, stage in structure.geared:
        base = turning[j - 2] if j > 1 else 0.0
        sizes = ["s"] + ["p"] * stage.planets
        for size in sizes:
            per, u, kappa = (numbers[f"{name}_{size}{j}"] for name in ("inv", "u", "kappa"))
            # J (a x' + base + rho theta')^2 with u = 1 / a, kappa = rho / a, inv = 1 / (J a^2)
            rate = v[:, place] + u * base + kappa * v[:, first + j - 1]
            energy += rate**2 / (2 * per)
            place += 1
    return energy


def _of_links(links: Links, turned: np.ndarray, turning: np.ndarray) -> np.ndarray:
    """(records,) [J], of absolute angles and rates (joints, records); pair by pair of links, so
    that no more numbers are at hand than the records have."""
    inertia = (links.coupling + links.constant).diagonal()
    energy = (inertia[:, None] * turning**2).sum(axis=0) / 2
    for k, before in combinations(range(len(turned)), 2):
        between = links.coupling[k, before] * np.cos(turned[k] - turned[before])
        energy += (between + links.constant[k, before]) * turning[k] * turning[before]
    return energy
