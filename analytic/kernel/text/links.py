"""The equations of one structure over its links: text written out without a loop over its parts.

Absolute link angles Theta_k and rates Omega_k; links l and k exert on each other what
m_kl cos(Theta_k - Theta_l) makes of them. A gear's displacement x takes part by the force f on it:
see crosscheck.analytic.kernel.links and numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from crosscheck.analytic.derivation.gears import Gears
from crosscheck.analytic.kernel.links import Links
from crosscheck.analytic.kernel.structure import Lines, StageShape, Structure, common_structure
from crosscheck.analytic.kernel.text.functions import cosine, sine
from crosscheck.analytic.kernel.text.meshes import (
    PER_TURN,
    mesh_forces,
    stiffness_and_error,
    torque,
)
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Layout
from crosscheck.models.experiment.drive import DriveData


@dataclass(frozen=True)
class LinkStructure(Structure):
    """The structure of a model whose equations are over the links of an arm's own bodies.

    spread: the constant inertia couples neighbouring links.
    """

    spread: bool
    gravity: bool
    friction: bool

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """x_s and every planet's x_pr of stage after stage, then theta of joint after joint."""
        gears = [
            name
            for j, stage in self.geared_joints
            for name in (f"x_s{j}", *(f"x_pr{j}_{n}" for n in range(1, stage.planets + 1)))
        ]
        return (*gears, *(f"theta{j}" for j in self.joints))

    def acceleration(self) -> Lines:
        """Lines from a member's coordinates and rates to its accelerations and mesh forces."""
        return acceleration(self)


def build_link_structure(
    arm: Arm, layout: Layout, gears: Gears, drive: DriveData, links: Links
) -> LinkStructure:
    """The structure of a model over its links."""
    return LinkStructure(
        *common_structure(layout.theta.tolist(), gears, drive),
        spread=links.spread,
        gravity=any(arm.gravity_m_per_s2),
        friction=any(joint.friction_N_m_s_per_rad for joint in arm.joints),
    )


def acceleration(s: LinkStructure) -> Lines:
    """Lines from a member's coordinates and rates to its accelerations and mesh forces."""
    yield from _links(s)
    for j in s.joints:
        stage = s.stages[j - 1]
        yield from torque(s, j)
        if stage is None:
            yield f"tau{j} = T{j}"
            yield f"base{j} = 0.0"
        else:
            yield from _stage(s, j, stage)
        if s.friction:
            yield f"tau{j} = tau{j} - friction{j} * v_theta{j}"
        yield f"r{j} = r{j} + tau{j}"
        if j > 1:
            yield f"r{j - 1} = r{j - 1} + base{j} - tau{j}"
    yield from _solve(s)
    yield from _gears(s)


def _links(s: LinkStructure) -> Lines:
    """Lines of M, and r: weight and what turning does, r_k = -sum m_kl sin(.) Omega_l^2."""
    for k in s.joints:
        yield f"Theta{k} = " + (f"Theta{k - 1} + " if k > 1 else "") + f"q_theta{k}"
        yield f"Omega{k} = " + (f"Omega{k - 1} + " if k > 1 else "") + f"v_theta{k}"
        yield f"spin{k} = Omega{k} * Omega{k}"
        yield from _direction(s, k)
    for k in s.joints:
        weight = f"weight_y{k} * c{k} - weight_x{k} * s{k}" if s.gravity else "0.0"
        yield f"r{k} = {weight}"
        yield f"M{k}_{k} = m{k}_{k}"
        for i in range(1, k):
            yield from _pair(s, k, i)


def _direction(s: LinkStructure, k: int) -> Lines:
    """Lines of cosine and sine of a link's angle: without weight, from the first link on."""
    if k == 1 and not s.gravity:
        return
    angle = f"Theta{k}" if s.gravity else f"(Theta{k} - Theta1)"
    yield from cosine(f"c{k}", f"{angle} * {PER_TURN}")
    yield from sine(f"s{k}", f"{angle} * {PER_TURN}")


def _pair(s: LinkStructure, k: int, i: int) -> Lines:
    if i == 1 and not s.gravity:
        cos, sin = f"c{k}", f"s{k}"
    else:
        cos, sin = f"(c{k} * c{i} + s{k} * s{i})", f"(s{k} * c{i} - c{k} * s{i})"
    yield f"M{k}_{i} = m{k}_{i} * {cos}" + (f" + G{k}_{i}" if s.spread else "")
    yield f"turning = m{k}_{i} * {sin}"
    yield f"r{k} = r{k} - turning * spin{i}"
    yield f"r{i} = r{i} + turning * spin{k}"


def _stage(s: LinkStructure, j: int, stage: StageShape) -> Lines:
    """Lines of forces f on displacements, and what they take from the joint and the link before.

    The torque turns the sun by T / n against the link before; on the joint its two parts cancel.
    """
    yield from stiffness_and_error(s, j, stage)
    planets = [(f"sp{j}_{n}", f"pr{j}_{n}", f"{j}_{n}") for n in range(1, stage.planets + 1)]
    for sun, ring, planet in planets:
        yield f"x_{sun} = q_x_s{j} - q_x_pr{planet}"
        yield f"x_{ring} = q_x_pr{planet}"
        yield f"v_{sun} = v_x_s{j} - v_x_pr{planet}"
        yield f"v_{ring} = v_x_pr{planet}"
    yield from mesh_forces(s, j, stage)
    for n, (sun, ring, planet) in enumerate(planets):
        yield f"f_{sun} = F_{sun} + D_{sun}"
        yield f"f_p{planet} = f_{sun} - (F_{ring} + D_{ring})"
        yield f"f_sp{j} = " + (f"f_sp{j} + " if n else "") + f"f_{sun}"
        yield f"f_p{j} = " + (f"f_p{j} + " if n else "") + f"f_p{planet}"
    yield f"tau{j} = kappa_s{j} * f_sp{j} - kappa_p{j} * f_p{j}" + (
        f" + on_theta{j}" if s.conservative else ""
    )
    yield f"base{j} = u_s{j} * f_sp{j} - u_p{j} * f_p{j} - reaction{j} * T{j}"


def _solve(s: LinkStructure) -> Lines:
    """Lines that solve M Theta'' = r by M = L D L^T from the tip on, and then give theta''.

    The tip's own inertia is a number. M is positive definite: no pivots.
    """
    tip = len(s.stages)
    for p in reversed(s.joints):
        yield f"inv{p} = " + (f"per_m{p}_{p}" if p == tip else f"1.0 / M{p}_{p}")
        for k in range(p - 1, 0, -1):
            yield f"L{k}_{p} = M{p}_{k} * inv{p}"
            for i in range(p - 1, k - 1, -1):
                yield f"M{i}_{k} = M{i}_{k} - L{k}_{p} * M{p}_{i}"
            yield f"r{k} = r{k} - L{k}_{p} * r{p}"
    for k in s.joints:
        yield f"A{k} = r{k} * inv{k}" + "".join(f" - L{i}_{k} * A{i}" for i in range(1, k))
    for k in s.joints:
        yield f"a_theta{k} = A{k}" + (f" - A{k - 1}" if k > 1 else "")


def _gears(s: LinkStructure) -> Lines:
    for j, stage in s.geared_joints:
        before = f"u_{{0}}{j} * A{j - 1} + " if j > 1 else ""
        carried = f" - ({before}kappa_{{0}}{j} * a_theta{j})"
        yield f"f_s{j} = advance{j} * T{j} - f_sp{j}"
        yield f"a_x_s{j} = inv_s{j} * f_s{j}" + carried.format("s")
        for n in range(1, stage.planets + 1):
            yield f"a_x_pr{j}_{n} = inv_p{j} * f_p{j}_{n}" + carried.format("p")
