"""The numbers of one model by the names that a kernel's text has for them."""

from __future__ import annotations

import math

import numpy as np

from analytic.fast.links import Links
from analytic.fast.structure import StageShape, Structure
from analytic.gears import Gears
from analytic.kinematics import gear_angles, stage_geometry
from analytic.stage import equivalent_masses
from analytic.stiffness import SINE
from models.arm import Arm, Planetary
from models.drive import DriveData

TURN = 2 * math.pi
Numbers = dict[str, float]


def numbers_of(
    arm: Arm, structure: Structure, links: Links, gears: Gears, drive: DriveData
) -> Numbers:
    """Everything that does not depend on the state, in SI units; phases in turns."""
    found = _of_links(arm, structure, links)
    for j in structure.joints:
        found |= {f"drive{j}_{place}": value for place, value in enumerate(drive.gains[j - 1])}
        found[f"friction{j}"] = arm.joints[j - 1].friction_N_m_s_per_rad
    first = 0
    for j, stage in structure.geared:
        joint = arm.joints[j - 1]
        assert isinstance(joint, Planetary)  # as joints with mesh displacements are
        meshes = range(first, first + 2 * stage.planets)
        found |= _of_gears(joint, j, stage)
        sun, ring = gears.rate[first], gears.rate[first + 1]
        found |= {f"rate_sp{j}": sun / TURN, f"rate_pr{j}": ring / TURN}
        for mesh in meshes[: 2 if stage.alike else None]:
            planet, side = divmod(mesh - first, 2)
            name = stage.numbers_of(("sp", "pr")[side], j, planet + 1)
            found |= _of_mesh(gears, mesh, name, stage.harmonics)
        first = meshes.stop
    return {name: float(value) for name, value in found.items()}


def _of_links(arm: Arm, structure: Structure, links: Links) -> Numbers:
    found = {}
    g_x, g_y = arm.gravity_m_per_s2
    for k in structure.joints:
        found[f"weight_x{k}"] = g_x * links.lever[k - 1]
        found[f"weight_y{k}"] = g_y * links.lever[k - 1]
        for i in range(1, k + 1):
            constant = links.constant[k - 1, i - 1]
            found[f"m{k}_{i}"] = links.coupling[k - 1, i - 1] + (constant if k == i else 0.0)
            found[f"G{k}_{i}"] = constant
        found[f"per_m{k}_{k}"] = 1 / found[f"m{k}_{k}"]
    return found


def _of_gears(joint: Planetary, j: int, stage: StageShape) -> Numbers:
    """Of sun and planets: what a force on a displacement does to it and to the links.

    A gear's spin is a x + Theta before the joint + rho theta. So force f on x turns it by
    f / (J a^2), and takes u f = f / a from the link before and kappa f = rho f / a from the joint.
    """
    geometry = stage_geometry(joint)
    radii = geometry.r_s, geometry.r_p, geometry.r_cp
    rho_s, minus_rho_p = gear_angles(0.0, 0.0, 1.0, *radii)
    a_s = gear_angles(1.0, 0.0, 0.0, *radii)[0]
    a_p = -gear_angles(0.0, 1.0, 0.0, *radii)[1]
    sun, planet, _ = equivalent_masses(joint)
    together = joint.planet_count // stage.planets
    return {
        f"inv_s{j}": 1 / (sun * geometry.r_s**2 * a_s**2),
        f"inv_p{j}": 1 / (together * planet * geometry.r_p**2 * a_p**2),
        f"u_s{j}": 1 / a_s,
        f"u_p{j}": 1 / a_p,
        f"kappa_s{j}": rho_s / a_s,
        f"kappa_p{j}": -minus_rho_p / a_p,
        f"share{j}": 1 / together,
        f"advance{j}": a_s / geometry.n,
        f"reaction{j}": 1 / geometry.n,
    }


def _of_mesh(gears: Gears, mesh: int, name: str, harmonics: int) -> Numbers:
    """Stiffness, of all planets that the mesh stands for, and error as waves of the joint's phase.

    k = k0 + sum kn_s sin(n phi) + kn_c cos(n phi), e = e0 + e_s sin(phi) + e_c cos(phi), phi
    without the mesh's own constant.
    """
    planets, offset = gears.planets[mesh], gears.offset[mesh]
    turned = offset + gears.lead[mesh]
    found = {
        f"k0_{name}": planets * gears.k_m[mesh],
        f"e0_{name}": gears.static[mesh],
        f"e_s_{name}": gears.E[mesh] * math.cos(turned),
        f"e_c_{name}": gears.E[mesh] * math.sin(turned) if turned else 0.0,
        f"b_{name}": gears.b[mesh],
        f"d_{name}": gears.d[mesh],
        f"sigma_{name}": gears.sigma[mesh],
        f"slope_{name}": gears.rate[mesh],
    }
    cosines, sines = _waves(gears, mesh, harmonics)
    for n in range(1, harmonics + 1):
        c, s = (math.cos(n * offset), math.sin(n * offset)) if offset else (1.0, 0.0)
        found[f"k{n}_s_{name}"] = planets * (sines[n - 1] * c - cosines[n - 1] * s)
        found[f"k{n}_c_{name}"] = planets * (sines[n - 1] * s + cosines[n - 1] * c)
    return found


def _waves(gears: Gears, mesh: int, harmonics: int) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes [N/m] of cos(n phi) and sin(n phi) of one planet's stiffness, n = 1, 2, ..."""
    cosines, sines = np.zeros((2, harmonics))
    if gears.law.code[mesh] == SINE:
        sines[0] = gears.k_a[mesh]
    else:
        rows = gears.law.rows[gears.law.first[mesh] : gears.law.first[mesh + 1]]
        cosines[: len(rows)], sines[: len(rows)] = rows[:, 1], rows[:, 2]
    return cosines, sines
