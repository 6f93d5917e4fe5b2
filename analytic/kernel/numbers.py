"""The numbers of one model by the names that a kernel's text has for them."""

from __future__ import annotations

import math

import numpy as np

from crosscheck.analytic.derivation.gears import Gears
from crosscheck.analytic.derivation.stage import equivalent_masses
from crosscheck.analytic.derivation.terms import Terms
from crosscheck.analytic.kernel.links import Links
from crosscheck.analytic.kernel.structure import StageShape, Structure
from crosscheck.analytic.kernel.text.links import LinkStructure
from crosscheck.analytic.kernel.text.terms import TermStructure
from crosscheck.analytic.paper.kinematics import gear_angles, stage_geometry
from crosscheck.analytic.paper.stiffness import SINE, TABLE, WAVES
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.experiment.drive import DriveData

TURN = 2 * math.pi
Numbers = dict[str, float | np.ndarray]  # a row's, or a table's rows in their order


def link_numbers(
    arm: Arm, structure: LinkStructure, links: Links, gears: Gears, drive: DriveData
) -> Numbers:
    """Numbers of a LinkStructure: all that does not depend on the state, in SI units."""
    numbers = _coupling_numbers(arm, structure, links) | mesh_numbers(arm, structure, gears, drive)
    for j, stage in structure.geared_joints:
        joint = arm.joints[j - 1]
        assert isinstance(joint, Planetary)  # as joints with mesh displacements are
        numbers |= _gear_numbers(joint, j, stage)
    return numbers


def term_numbers(
    arm: Arm, structure: TermStructure, terms: Terms, gears: Gears, drive: DriveData
) -> Numbers:
    """Numbers of a TermStructure: all that does not depend on the state, in SI units."""
    numbers = mesh_numbers(arm, structure, gears, drive)
    for name, values in (("mass", terms.mass_coeff), ("bias", terms.bias_coeff)):
        numbers |= {f"{name}_{k}": value for k, value in enumerate(values)}
    for k, (of_cosine, of_sine) in enumerate(terms.weight_coeff):
        numbers |= {f"weight_c{k}": of_cosine, f"weight_s{k}": of_sine}
    for row, joint in structure.drives:
        numbers[f"driven{row}_{joint}"] = terms.drive_map[row, joint]
    for row, mesh in structure.pushes:  # by the force of all planets that the mesh stands for
        numbers[f"pushed{row}_{mesh}"] = terms.mesh_map[row, mesh] / gears.planets[mesh]
    return numbers


def mesh_numbers(arm: Arm, structure: Structure, gears: Gears, drive: DriveData) -> Numbers:
    """Numbers of drive, friction and meshes, in SI units; phases in turns."""
    numbers = drive_numbers(drive) | stage_numbers(structure, gears)
    for j, joint in enumerate(arm.joints, 1):
        numbers[f"friction{j}"] = joint.friction_N_m_s_per_rad
    return numbers


def drive_numbers(drive: DriveData) -> Numbers:
    """Numbers of the drive's law, in SI units."""
    return {
        f"drive{j}_{place}": value
        for j, gains in enumerate(drive.gains, 1)
        for place, value in enumerate(gains)
    }


def stage_numbers(structure: Structure, gears: Gears) -> Numbers:
    """Numbers of the meshes of planetary stages, in SI units; phases in turns."""
    numbers: Numbers = {}
    first = 0
    for j, stage in structure.geared_joints:
        meshes = range(first, first + 2 * stage.planets)
        numbers[f"share{j}"] = 1 / gears.planets[first]
        sun, ring = gears.rate[first], gears.rate[first + 1]
        numbers |= {f"rate_sp{j}": sun / TURN, f"rate_pr{j}": ring / TURN}
        for mesh in meshes[: 2 if stage.equal_planets else None]:
            planet, side = divmod(mesh - first, 2)
            name = stage.numbers_name(("sp", "pr")[side], j, planet + 1)
            numbers |= _single_mesh_numbers(gears, mesh, name, stage)
        first = meshes.stop
    return numbers


def _coupling_numbers(arm: Arm, structure: LinkStructure, links: Links) -> Numbers:
    numbers: Numbers = {}
    g_x, g_y = arm.gravity_m_per_s2
    for k in structure.joints:
        numbers[f"weight_x{k}"] = g_x * links.lever[k - 1]
        numbers[f"weight_y{k}"] = g_y * links.lever[k - 1]
        for i in range(1, k + 1):
            constant = links.constant[k - 1, i - 1]
            coupling = links.coupling[k - 1, i - 1] + (constant if k == i else 0.0)
            numbers |= {f"m{k}_{i}": coupling, f"G{k}_{i}": constant}
        numbers[f"per_m{k}_{k}"] = 1 / coupling
    return numbers


def _gear_numbers(joint: Planetary, j: int, stage: StageShape) -> Numbers:
    """Numbers of sun and planets: what a force on a displacement does to it and to the links.

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
        f"advance{j}": a_s / geometry.n,
        f"reaction{j}": 1 / geometry.n,
    }


def _single_mesh_numbers(gears: Gears, mesh: int, name: str, stage: StageShape) -> Numbers:
    """Numbers of a mesh: stiffness of all its planets, and error, as waves of the joint's phase.

    k = k0 + sum kn_s sin(n phi) + kn_c cos(n phi), e = e0 + e_s sin(phi) + e_c cos(phi), phi
    without the mesh's own constant; a table's stiffness is all in its pieces.
    """
    planets, offset = gears.planets[mesh], gears.offset[mesh]
    turned, tabled = offset + gears.error_phase[mesh], gears.law.code[mesh] == TABLE
    numbers: Numbers = {
        f"k0_{name}": 0.0 if tabled else planets * gears.k_m[mesh],
        f"e0_{name}": gears.static_error[mesh],
        f"e_s_{name}": gears.E[mesh] * math.cos(turned),
        f"e_c_{name}": gears.E[mesh] * math.sin(turned) if turned else 0.0,
        f"b_{name}": gears.b[mesh],
        f"d_{name}": gears.d[mesh],
        f"sigma_{name}": gears.sigma[mesh],
        f"slope_{name}": gears.rate[mesh],
        f"ahead_{name}": offset / TURN,
    }
    cosines, sines = _waves(gears, mesh, stage.harmonics)
    for n in range(1, stage.harmonics + 1):
        c, s = (math.cos(n * offset), math.sin(n * offset)) if offset else (1.0, 0.0)
        numbers[f"k{n}_s_{name}"] = planets * (sines[n - 1] * c - cosines[n - 1] * s)
        numbers[f"k{n}_c_{name}"] = planets * (sines[n - 1] * s + cosines[n - 1] * c)
    return numbers | _pieces(gears, mesh, name, stage.pieces)


def _pieces(gears: Gears, mesh: int, name: str, count: int) -> Numbers:
    """Beginnings of a table's pieces [cycles], and their cubics, constant part first.

    Filled up to ``count`` by pieces that begin nowhere; cubics are 0 for a mesh without a table.
    """
    if not count:
        return {}
    begin = np.full(count, np.inf)
    begin[0] = 0.0
    cubics = np.zeros((4, count))
    if gears.law.code[mesh] == TABLE:
        rows = gears.law.rows[gears.law.first[mesh] : gears.law.first[mesh + 1]]
        begin[: len(rows)] = rows[:, 0]
        cubics[:, : len(rows)] = gears.planets[mesh] * rows[:, :0:-1].T
    numbers: Numbers = {f"rows_{name}_{power}": cubic for power, cubic in enumerate(cubics)}
    return numbers | {f"rows_{name}_begin": begin}


def _waves(gears: Gears, mesh: int, harmonics: int) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes [N/m] of cos(n phi) and sin(n phi) of one planet's stiffness, n = 1, 2, ..."""
    cosines, sines = np.zeros((2, harmonics))
    if gears.law.code[mesh] == SINE:
        sines[:1] = gears.k_a[mesh]
    elif gears.law.code[mesh] == WAVES:
        rows = gears.law.rows[gears.law.first[mesh] : gears.law.first[mesh + 1]]
        cosines[: len(rows)], sines[: len(rows)] = rows[:, 1], rows[:, 2]
    return cosines, sines
