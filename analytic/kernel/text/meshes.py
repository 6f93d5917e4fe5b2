"""Text that every form of the equations shares: driving torques and mesh forces."""

from __future__ import annotations

from crosscheck.analytic.kernel.structure import Lines, StageShape, Structure
from crosscheck.analytic.kernel.text.functions import cosine, hyperbolic_tangent, reduce_turns, sine
from crosscheck.models.experiment.drive import CONSTANT, PD, SINE_OF_SQRT_TIME, SINE_OF_TIME

PER_TURN = repr(0.15915494309189535)  # 1 / 2 pi


def torque(s: Structure, j: int) -> Lines:
    """Lines of T of models.experiment.drive at one joint; a table's is given, one for all lanes."""
    if s.drive == CONSTANT:
        yield f"T{j} = drive{j}_0"
    elif s.drive == PD:
        yield f"T{j} = drive{j}_1 * (drive{j}_0 - q_theta{j}) - drive{j}_2 * v_theta{j}"
    elif s.drive in (SINE_OF_TIME, SINE_OF_SQRT_TIME):
        of = "t" if s.drive == SINE_OF_TIME else "root_t"
        yield from sine(f"wave_T{j}", f"drive{j}_1 * {of} * {PER_TURN}")
        yield f"T{j} = drive{j}_0 * wave_T{j}"
    else:
        yield f"T{j} = table{j}"


def list_meshes(stage: StageShape, j: int) -> list[tuple[str, str, str]]:
    """(mesh, name of its numbers, side whose sines it has) of a stage, as ``Structure.meshes``."""
    sines = {"sp": "sp", "pr": "sp" if stage.shared_rate else "pr"}
    return [
        (f"{side}{j}_{n}", stage.numbers_name(side, j, n), sines[side])
        for n in range(1, stage.planets + 1)
        for side in ("sp", "pr")
    ]


def stiffness_and_error(s: Structure, j: int, stage: StageShape) -> Lines:
    """Lines of k and e of every mesh of a stage that has numbers of its own."""
    for side in ("sp",) if stage.shared_rate else ("sp", "pr"):
        yield from _waves(s, j, side, stage)
    for suffix, side in {suffix: side for _, suffix, side in list_meshes(stage, j)}.items():
        if stage.pieces:
            yield from _curve(s, j, suffix, side, stage)
        yield from _wave(suffix, f"{side}{j}", stage)


def mesh_forces(s: Structure, j: int, stage: StageShape) -> Lines:
    """Lines of the force F and the damper's D of every mesh of a stage, from its x and v.

    Both are of all planets that the mesh stands for, ``each`` is the force of one. With
    conservative springs on_theta is what they do to the joint's angle.
    """
    if s.conservative:
        yield f"on_theta{j} = 0.0"
    for mesh, suffix, side in list_meshes(stage, j):
        yield from _mesh(s, j, mesh, suffix, stage)
        if s.conservative:
            yield from _angle_torque(j, mesh, suffix, f"{side}{j}", stage)


def constant_mesh(s: Structure, mesh: str) -> Lines:
    """Lines of the force F and the damper's D of a mesh of constant stiffness without errors."""
    yield f"gap_{mesh} = q_x_{mesh}"
    yield from _travel(s, f"gap_{mesh}", mesh)
    yield f"F_{mesh} = k_{mesh} * travel"
    yield f"each_{mesh} = F_{mesh}"
    yield f"D_{mesh} = d_{mesh} * v_x_{mesh} if abs(gap_{mesh}) > b_{mesh} else 0.0"


def _waves(s: Structure, j: int, side: str, stage: StageShape) -> Lines:
    """Lines of sines and cosines of n phi of a stage's meshes on one side, as many as they need."""
    name, turns = f"{side}{j}", s.turns(j, side)
    yield from sine(f"s1_{name}", turns)
    if stage.has_cosines or s.conservative:
        yield from cosine(f"c1_{name}", turns)
    for n in range(2, stage.harmonics + 1):
        a, b = n // 2, n - n // 2
        yield f"s{n}_{name} = s{a}_{name} * c{b}_{name} + c{a}_{name} * s{b}_{name}"
        yield f"c{n}_{name} = c{a}_{name} * c{b}_{name} - s{a}_{name} * s{b}_{name}"


def _wave(suffix: str, phase: str, stage: StageShape) -> Lines:
    """Lines of stiffness k and error e of meshes with the same numbers."""
    stiffness, error = f"k0_{suffix}", f"e0_{suffix} + e_s_{suffix} * s1_{phase}"
    if stage.pieces:
        stiffness += f" + curve_{suffix}"
    for n in range(1, stage.harmonics + 1):
        stiffness += f" + k{n}_s_{suffix} * s{n}_{phase}"
        if stage.has_cosines:
            stiffness += f" + k{n}_c_{suffix} * c{n}_{phase}"
    if stage.has_cosines:
        error += f" + e_c_{suffix} * c1_{phase}"
    yield f"k_{suffix} = {stiffness}"
    yield f"e_{suffix} = {error}"


def _curve(s: Structure, j: int, suffix: str, side: str, stage: StageShape) -> Lines:
    """Lines of a table's stiffness and its slope over the phase [rad]; halving finds a piece."""
    cycle, place, into = f"cycle_{suffix}", f"place_{suffix}", f"into_{suffix}"
    yield from reduce_turns(cycle, f"{s.turns(j, side)} + ahead_{suffix}")
    yield f"{cycle} = {cycle} + 1.0 if {cycle} < 0.0 else {cycle}"
    yield f"{place} = 0.0"
    step = stage.pieces // 2
    while step:
        ahead = f"{place} + {float(step)!r}"
        begun = f"pick(w, rows_{suffix}_begin, {ahead})"
        yield f"{place} = {ahead} if {begun} <= {cycle} else {place}"
        step //= 2
    yield f"{into} = {cycle} - pick(w, rows_{suffix}_begin, {place})"
    for power in range(4):
        yield f"piece{power}_{suffix} = pick(w, rows_{suffix}_{power}, {place})"
    c0, c1, c2, c3 = (f"piece{power}_{suffix}" for power in range(4))
    yield f"curve_{suffix} = {c0} + {into} * ({c1} + {into} * ({c2} + {into} * {c3}))"
    if s.conservative:
        slope = f"{c1} + {into} * (2.0 * {c2} + {into} * (3.0 * {c3}))"
        yield f"curve_slope_{suffix} = ({slope}) * {PER_TURN}"


def _mesh(s: Structure, j: int, mesh: str, suffix: str, stage: StageShape) -> Lines:
    yield f"gap_{mesh} = x_{mesh} - e_{suffix}"
    yield from _travel(s, f"gap_{mesh}", suffix)
    yield f"F_{mesh} = k_{suffix} * travel"
    yield f"each_{mesh} = F_{mesh}" + (f" * share{j}" if stage.planets == 1 else "")
    yield f"D_{mesh} = d_{suffix} * v_{mesh}"
    if not s.damps_without_contact:
        yield f"D_{mesh} = D_{mesh} if abs(gap_{mesh}) > b_{suffix} else 0.0"


def _travel(s: Structure, gap: str, suffix: str) -> Lines:
    """Lines of f_k by Eq. 5 or 6."""
    b = f"b_{suffix}"
    if s.tanh:
        yield from hyperbolic_tangent("right", f"sigma_{suffix} * ({gap} - {b})")
        yield from hyperbolic_tangent("left", f"sigma_{suffix} * ({gap} + {b})")
        yield f"travel = {gap} + {gap} / 2.0 * (right - left) - {b} / 2.0 * (right + left)"
    else:
        yield f"inside = {b} if {gap} > {b} else {gap}"
        yield f"inside = -{b} if inside < -{b} else inside"
        yield f"travel = {gap} - inside"


def _angle_torque(j: int, mesh: str, suffix: str, phase: str, stage: StageShape) -> Lines:
    """Lines that compute -dV/dtheta, where V = k f^2 / 2 summed over the mesh's planets."""
    slopes = [f"curve_slope_{suffix}"] * bool(stage.pieces) + [
        f"{float(n)!r} * (k{n}_s_{suffix} * c{n}_{phase} - k{n}_c_{suffix} * s{n}_{phase})"
        for n in range(1, stage.harmonics + 1)
    ]
    yield f"error_slope = e_s_{suffix} * c1_{phase} - e_c_{suffix} * s1_{phase}"
    yield f"on_phase = F_{mesh} * error_slope - ({' + '.join(slopes)}) * travel * travel / 2.0"
    yield f"on_theta{j} = on_theta{j} + slope_{suffix} * on_phase"
