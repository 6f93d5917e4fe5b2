"""The text of a kernel: the equations of one structure, written out without a loop over its parts.

Absolute link angles Theta_k and rates Omega_k; links l and k exert on each other what
m_kl cos(Theta_k - Theta_l) makes of them. A gear's displacement x takes part by the force f on it:
see analytic.fast.links and numbers. Every quantity of a member is an entry of one flat array, rows
of a fixed number of lanes: so a compiler knows that they do not overlap, and works on lanes side by
side. Sums of products may be fused (LLVM's ``contract``); nothing else is relaxed.
"""

from __future__ import annotations

from collections.abc import Iterator

from analytic.fast.sines import cosine, sine
from analytic.fast.structure import StageShape, Structure
from models.drive import CONSTANT, PD, SINE_OF_SQRT_TIME, SINE_OF_TIME

Lines = Iterator[str]


def acceleration(s: Structure, alone: bool) -> Lines:
    """From a member's coordinates and rates to their accelerations and the mesh forces.

    alone: one member, see analytic.fast.sines.
    """
    yield from _links(s, alone)
    for j in s.joints:
        stage = s.stages[j - 1]
        yield from _torque(s, j, alone)
        if stage is None:
            yield f"tau{j} = T{j}"
            yield f"base{j} = 0.0"
        else:
            yield from _stage(s, j, stage, alone)
        if s.friction:
            yield f"tau{j} = tau{j} - friction{j} * v_theta{j}"
        yield f"r{j} = r{j} + tau{j}"
        if j > 1:
            yield f"r{j - 1} = r{j - 1} + base{j} - tau{j}"
    yield from _solve(s)
    yield from _gears(s)


def _links(s: Structure, alone: bool) -> Lines:
    """M and, on the right, weight and what turning does: r_k = -sum m_kl sin(.) Omega_l^2."""
    for k in s.joints:
        yield f"Theta{k} = " + (f"Theta{k - 1} + " if k > 1 else "") + f"q_theta{k}"
        yield f"Omega{k} = " + (f"Omega{k - 1} + " if k > 1 else "") + f"v_theta{k}"
        yield f"spin{k} = Omega{k} * Omega{k}"
        yield from _direction(s, k, alone)
    for k in s.joints:
        weight = f"weight_y{k} * c{k} - weight_x{k} * s{k}" if s.gravity else "0.0"
        yield f"r{k} = {weight}"
        yield f"M{k}_{k} = m{k}_{k}"
        for i in range(1, k):
            yield from _pair(s, k, i)


def _direction(s: Structure, k: int, alone: bool) -> Lines:
    """Cosine and sine of a link's angle: without weight, from the first link on."""
    if k == 1 and not s.gravity:
        return
    angle = f"Theta{k}" if s.gravity else f"(Theta{k} - Theta1)"
    yield from cosine(f"c{k}", f"{angle} * {_PER_TURN}", alone)
    yield from sine(f"s{k}", f"{angle} * {_PER_TURN}", alone)


_PER_TURN = repr(0.15915494309189535)  # 1 / 2 pi


def _pair(s: Structure, k: int, i: int) -> Lines:
    if i == 1 and not s.gravity:
        cos, sin = f"c{k}", f"s{k}"
    else:
        cos, sin = f"(c{k} * c{i} + s{k} * s{i})", f"(s{k} * c{i} - c{k} * s{i})"
    yield f"M{k}_{i} = m{k}_{i} * {cos}" + (f" + G{k}_{i}" if s.spread else "")
    yield f"turning = m{k}_{i} * {sin}"
    yield f"r{k} = r{k} - turning * spin{i}"
    yield f"r{i} = r{i} + turning * spin{k}"


def _torque(s: Structure, j: int, alone: bool) -> Lines:
    """T of models.drive at one joint; a table's is the same for all lanes, and given."""
    if s.drive == CONSTANT:
        yield f"T{j} = drive{j}_0"
    elif s.drive == PD:
        yield f"T{j} = drive{j}_1 * (drive{j}_0 - q_theta{j}) - drive{j}_2 * v_theta{j}"
    elif s.drive in (SINE_OF_TIME, SINE_OF_SQRT_TIME):
        of = "t" if s.drive == SINE_OF_TIME else "root_t"
        yield from sine(f"wave_T{j}", f"drive{j}_1 * {of} * {_PER_TURN}", alone)
        yield f"T{j} = drive{j}_0 * wave_T{j}"
    else:
        yield f"T{j} = table{j}"


def _stage(s: Structure, j: int, stage: StageShape, alone: bool) -> Lines:
    """Forces f on the displacements, and what they take from the joint and the link before.

    The torque turns the sun by T / n against the link before; on the joint its two parts cancel.
    """
    sides = ("sp",) if stage.one_rate else ("sp", "pr")
    for side in sides:
        yield from _waves(s, j, side, stage, alone)
    yield f"f_s{j} = 0.0"
    yield f"f_p{j} = 0.0"
    if s.conservative:
        yield f"on_theta{j} = 0.0"
    phases = dict(zip(("sp", "pr"), (f"{sides[0]}{j}", f"{sides[-1]}{j}"), strict=True))
    for n in range(1, 2 if stage.alike else stage.planets + 1):
        for side, phase in phases.items():
            yield from _wave(stage.numbers_of(side, j, n), phase, stage)
    for n in range(1, stage.planets + 1):
        sun, ring = f"sp{j}_{n}", f"pr{j}_{n}"
        yield f"x_{sun} = q_x_s{j} - q_x_pr{j}_{n}"
        yield f"x_{ring} = q_x_pr{j}_{n}"
        yield f"v_{sun} = v_x_s{j} - v_x_pr{j}_{n}"
        yield f"v_{ring} = v_x_pr{j}_{n}"
        for side, mesh in (("sp", sun), ("pr", ring)):
            yield from _mesh(s, j, mesh, stage.numbers_of(side, j, n), phases[side], stage)
        yield f"f_{sun} = F_{sun} + D_{sun}"
        yield f"f_p{j}_{n} = f_{sun} - (F_{ring} + D_{ring})"
        yield f"f_s{j} = f_s{j} - f_{sun}"
        yield f"f_p{j} = f_p{j} + f_p{j}_{n}"
    yield f"tau{j} = -(kappa_s{j} * f_s{j} + kappa_p{j} * f_p{j})" + (
        f" + on_theta{j}" if s.conservative else ""
    )
    yield f"base{j} = -(u_s{j} * f_s{j} + u_p{j} * f_p{j} + reaction{j} * T{j})"


def _waves(s: Structure, j: int, side: str, stage: StageShape, alone: bool) -> Lines:
    """Sines and cosines of n phi of a stage's meshes on one side, n up to what they need."""
    driven = f"v_theta{j} * t" if s.omega_t else f"q_theta{j}"
    name = f"{side}{j}"
    yield from sine(f"s1_{name}", f"rate_{side}{j} * ({driven})", alone)
    if _needs_cosine(s, stage):
        yield from cosine(f"c1_{name}", f"rate_{side}{j} * ({driven})", alone)
    for n in range(2, stage.harmonics + 1):
        a, b = n // 2, n - n // 2
        yield f"s{n}_{name} = s{a}_{name} * c{b}_{name} + c{a}_{name} * s{b}_{name}"
        yield f"c{n}_{name} = c{a}_{name} * c{b}_{name} - s{a}_{name} * s{b}_{name}"


def _needs_cosine(s: Structure, stage: StageShape) -> bool:
    return stage.turned or s.conservative


def _wave(own: str, phase: str, stage: StageShape) -> Lines:
    """Stiffness k and error e of meshes with the same numbers."""
    stiffness, error = f"k0_{own}", f"e0_{own} + e_s_{own} * s1_{phase}"
    for n in range(1, stage.harmonics + 1):
        stiffness += f" + k{n}_s_{own} * s{n}_{phase}"
        if stage.turned:
            stiffness += f" + k{n}_c_{own} * c{n}_{phase}"
    if stage.turned:
        error += f" + e_c_{own} * c1_{phase}"
    yield f"k_{own} = {stiffness}"
    yield f"e_{own} = {error}"


def _mesh(s: Structure, j: int, mesh: str, own: str, phase: str, stage: StageShape) -> Lines:
    """Force F, of all planets that the mesh stands for, and damper D of a mesh."""
    yield f"gap_{mesh} = x_{mesh} - e_{own}"
    yield from _travel(s, f"gap_{mesh}", own)
    yield f"F_{mesh} = k_{own} * travel"
    yield f"each_{mesh} = F_{mesh}" + (f" * share{j}" if stage.planets == 1 else "")
    yield f"D_{mesh} = d_{own} * v_{mesh}"
    if not s.damps_apart:
        yield f"D_{mesh} = D_{mesh} if abs(gap_{mesh}) > b_{own} else 0.0"
    if s.conservative:
        yield from _on_angle(j, mesh, own, phase, stage)


def _travel(s: Structure, gap: str, own: str) -> Lines:
    """f_k of Eq. 5 or 6."""
    b = f"b_{own}"
    if s.tanh:
        yield f"right = tanh(sigma_{own} * ({gap} - {b}))"
        yield f"left = tanh(sigma_{own} * ({gap} + {b}))"
        yield f"travel = {gap} + {gap} / 2 * (right - left) - {b} / 2 * (right + left)"
    else:
        yield f"inside = {b} if {gap} > {b} else {gap}"
        yield f"inside = -{b} if inside < -{b} else inside"
        yield f"travel = {gap} - inside"


def _on_angle(j: int, mesh: str, own: str, phase: str, stage: StageShape) -> Lines:
    """-dV/dtheta of V = k f^2 / 2 of all planets that the mesh stands for."""
    slope = " + ".join(
        f"{n} * (k{n}_s_{own} * c{n}_{phase} - k{n}_c_{own} * s{n}_{phase})"
        for n in range(1, stage.harmonics + 1)
    )
    yield f"error_slope = e_s_{own} * c1_{phase} - e_c_{own} * s1_{phase}"
    yield f"on_phase = F_{mesh} * error_slope - ({slope}) * travel * travel / 2"
    yield f"on_theta{j} = on_theta{j} + slope_{own} * on_phase"


def _solve(s: Structure) -> Lines:
    """M Theta'' = r by M = L D L^T from the tip on, whose own inertia is a number; then theta''.

    M is positive definite: no pivots.
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


def _gears(s: Structure) -> Lines:
    for j, stage in s.geared:
        before = f"u_{{0}}{j} * A{j - 1} + " if j > 1 else ""
        carried = f" - ({before}kappa_{{0}}{j} * a_theta{j})"
        yield f"f_s{j} = f_s{j} + advance{j} * T{j}"
        yield f"a_x_s{j} = inv_s{j} * f_s{j}" + carried.format("s")
        for n in range(1, stage.planets + 1):
            yield f"a_x_pr{j}_{n} = inv_p{j} * f_p{j}_{n}" + carried.format("p")
