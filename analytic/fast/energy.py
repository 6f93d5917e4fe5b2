"""Kinetic energy along recorded states, of a member of a batch."""

from __future__ import annotations

import numpy as np

from analytic.fast.links import Links
from analytic.fast.numbers import Numbers
from analytic.fast.structure import Structure


def kinetic_energy(
    structure: Structure, links: Links, numbers: Numbers, x: np.ndarray, v: np.ndarray
) -> np.ndarray:
    """(records,) [J], of coordinates x and rates v (records, n) in the structure's order."""
    joints = len(structure.stages)
    turned, turning = (np.cumsum(each[:, -joints:], axis=1) for each in (x, v))
    between = np.cos(turned[:, :, None] - turned[:, None, :])
    inertia = links.coupling * between + links.constant
    energy = np.einsum("rk,rkl,rl->r", turning, inertia, turning) / 2
    place, first = 0, len(structure.coordinates) - joints
    for j, stage in structure.geared:
        base = turning[:, j - 2] if j > 1 else 0.0
        sizes = ["s"] + ["p"] * stage.planets
        for size in sizes:
            per, u, kappa = (numbers[f"{name}_{size}{j}"] for name in ("inv", "u", "kappa"))
            # J (a x' + base + rho theta')^2 with u = 1 / a, kappa = rho / a, inv = 1 / (J a^2)
            rate = v[:, place] + u * base + kappa * v[:, first + j - 1]
            energy += rate**2 / (2 * per)
            place += 1
    return energy
