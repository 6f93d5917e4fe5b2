"""Right equations of two-joint arms, written out as people write them: text, to plant mistakes in.

Each text fills M (n, n), h (n,) and f (n,) from x, v (n,), T (2,) and an arm's quantities by the
names of ``quantities``. None of it is taken from the project's own models.
"""

import math
from collections.abc import Mapping
from functools import lru_cache, partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.trial.input.equations import Coordinates, Equations

RELATIVE = """
c2, s2 = cos(x[1]), sin(x[1])
M[0, 0] = I1 + m1*d1**2 + I2 + m2*(L1**2 + d2**2 + 2*L1*d2*c2) + mp*(L1**2 + L2**2 + 2*L1*L2*c2)
M[0, 1] = I2 + m2*(d2**2 + L1*d2*c2) + mp*(L2**2 + L1*L2*c2)
M[1, 0] = M[0, 1]
M[1, 1] = I2 + m2*d2**2 + mp*L2**2
h[0] = -(m2*L1*d2 + mp*L1*L2)*s2*(2*v[0]*v[1] + v[1]**2)
h[1] = (m2*L1*d2 + mp*L1*L2)*s2*v[0]**2
f[0] = T[0] - k1*v[0]
f[0] -= g*(m1*d1 + m2*L1 + mp*L1)*cos(x[0]) + g*(m2*d2 + mp*L2)*cos(x[0] + x[1])
f[1] = T[1] - k2*v[1] - g*(m2*d2 + mp*L2)*cos(x[0] + x[1])
"""

ABSOLUTE = """
c, s = cos(x[0] - x[1]), sin(x[0] - x[1])
M[0, 0] = I1 + m1*d1**2 + m2*L1**2 + mp*L1**2
M[0, 1] = m2*L1*d2*c + mp*L1*L2*c
M[1, 0] = M[0, 1]
M[1, 1] = I2 + m2*d2**2 + mp*L2**2
h[0] = (m2*L1*d2 + mp*L1*L2)*s*v[1]**2
h[1] = -(m2*L1*d2 + mp*L1*L2)*s*v[0]**2
f[0] = T[0] - T[1] - k1*v[0] + k2*(v[1] - v[0]) - g*(m1*d1 + m2*L1 + mp*L1)*cos(x[0])
f[1] = T[1] - k2*(v[1] - v[0]) - g*(m2*d2 + mp*L2)*cos(x[1])
"""

LINKS = """
spin(I1 + m1*d1**2 + (m2 + mp + stages[1].m)*L1**2, phi[0])
spin(I2 + m2*d2**2 + mp*L2**2, phi[1])
M += L1*(m2*d2 + mp*L2)*cos(theta[1])*(outer(phi[0], phi[1]) + outer(phi[1], phi[0]))
h += L1*(m2*d2 + mp*L2)*sin(theta[1])*((phi[0] @ v)**2*phi[1] - (phi[1] @ v)**2*phi[0])
"""

MESHES = """
    for a, w, K, E, b, p, D in ((a_sp, w_sp, *s.sun), (a_pr, w_pr, *s.ring)):
        sine = sin(s.z_r*theta[j] + p)
        gap = a - E*sine
        F = (K[0] + K[1]*sine)*(gap - min(max(gap, -b), b))
        f -= s.N*F*w + D*(w @ v)*w
"""


def write_geared(phi: str, theta: str, motor: str, own: str) -> str:
    """The text of two geared joints, of which ``own`` has what their coordinates decide.

    phi: rotations of the links; theta: angles of the joints; motor: the rotation that it drives.
    """
    return f"""
phi = {phi}
theta = {theta}{LINKS}
for j, s in enumerate(stages):
    base = phi[0] if j else 0*e[0]{own}
    spin(s.M_c*s.r_cp**2 + s.N*s.m_p*s.r_c**2, phi[j])
    spin(s.J_r, base)
    f += T[j]/s.n*{motor}
    f -= s.k*(turn @ v)*turn{MESHES}"""


JOINT_ANGLES = "[e[2], e[2] + e[5]]", "[x[2], x[5]]"
# x = x_sp, x_pr and the joint's angle, of the shoulder and of the elbow.
DISPLACEMENTS = """
    x_sp, x_pr, turn = e[3*j], e[3*j + 1], e[3*j + 2]
    spin(s.M_s, x_sp + x_pr + 2*s.r_cp*turn + s.r_s*base)
    spin(s.N*s.M_p, x_pr + s.r_cp*turn - s.r_p*base)
    a_sp, w_sp, a_pr, w_pr = x[3*j], x_sp, x[3*j + 1], x_pr"""
# x = absolute rotations of a link, of the sun that drives it and of its planets.
SPINS = """
    sun, planet, turn = e[3*j + 1], e[3*j + 2], phi[j] - base
    spin(s.M_s*s.r_s**2, sun)
    spin(s.N*s.M_p*s.r_p**2, planet)
    w_sp = s.r_s*(sun - base) + s.r_p*(planet - base) - s.r_cp*turn
    w_pr = -s.r_p*(planet - base) - s.r_cp*turn
    a_sp, a_pr = w_sp @ x, w_pr @ x"""
# x = angles of sun, planets and link, relative to the body before; planets against the carrier.
ANGLES = """
    sun, planet, turn = e[3*j], e[3*j + 1], e[3*j + 2]
    spin(s.M_s*s.r_s**2, sun + base)
    spin(s.N*s.M_p*s.r_p**2, base - planet)
    w_sp = s.r_s*sun - s.r_p*planet - s.r_cp*turn
    w_pr = s.r_p*planet - s.r_cp*turn
    a_sp, a_pr = w_sp @ x, w_pr @ x"""

RIGHT = {
    "relative": RELATIVE,
    "absolute": ABSOLUTE,
    "displacements": write_geared(
        *JOINT_ANGLES, "(x_sp + x_pr + 2*s.r_cp*turn)/s.r_s", DISPLACEMENTS
    ),
    "spins": write_geared("[e[0], e[3]]", "[x[0], x[3] - x[0]]", "(sun - base)", SPINS),
    "angles": write_geared(*JOINT_ANGLES, "sun", ANGLES),
}
RIGID = ("relative", "absolute")
GEARS = ("sun", "planet", "carrier", "ring")


def quantities(arm: Arm) -> dict[str, Any]:
    """An arm's numbers by the names of the texts; of its geared joints in ``stages``."""
    found: dict[str, Any] = {"mp": arm.payload_mass_kg, "g": -arm.gravity_m_per_s2[1]}
    for number, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True), start=1):
        mass = link.density_kg_per_m3 * link.cross_section_m2 * link.length_m
        own = (mass, mass * link.length_m**2 / 12, link.com_m, link.length_m)
        own = (*own, joint.friction_N_m_s_per_rad)
        found |= {f"{name}{number}": value for name, value in zip("mIdLk", own, strict=True)}
    found["stages"] = [stage(joint) for joint in arm.joints if isinstance(joint, Planetary)]
    return found


def stage(joint: Planetary) -> SimpleNamespace:
    """Of one planetary gear; m: all that it weighs."""
    cosine = math.cos(math.radians(joint.pressure_angle_deg))
    N = joint.planet_count
    M_s, M_p = joint.sun_equivalent_mass_kg, joint.planet_equivalent_mass_kg
    found = SimpleNamespace(
        N=N,
        M_s=M_s,
        M_p=M_p,
        M_c=joint.carrier_equivalent_mass_kg,
        **{f"m_{each[0]}": getattr(joint, f"{each}_mass_kg") for each in GEARS},
        J_r=joint.ring_inertia_kg_m2,
        k=joint.friction_N_m_s_per_rad,
        **{f"z_{each[0]}": getattr(joint, f"{each}_teeth") for each in ("sun", "planet", "ring")},
        n=1 + joint.ring_teeth / joint.sun_teeth,
        cos_alpha=cosine,
        r_s=joint.module_m * joint.sun_teeth / 2 * cosine,
        r_p=joint.module_m * joint.planet_teeth / 2 * cosine,
        r_c=joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2,
    )
    found.r_cp = found.r_c * cosine
    found.m = found.m_s + N * found.m_p + found.m_c + found.m_r
    found.sun, found.ring = mesh(joint.sun_mesh, N, M_s), mesh(joint.ring_mesh, N, N * M_p)
    return found


def mesh(own: Any, count: int, mass: float) -> tuple[Any, ...]:
    """Stiffness (mean, amplitude), tooth error, half backlash, phase, damping of all planets."""
    stiffness = own.stiffness.mean_N_per_m, own.stiffness.amplitude_N_per_m
    damping = own.damping_N_s_per_m
    if damping is None:
        damping = 2 * own.damping_ratio * math.sqrt(count * stiffness[0] * mass)
    return stiffness, own.tooth_error_m, own.backlash_m, own.phase_rad, damping


def coordinates(kind: str, known: Mapping[str, Any]) -> Coordinates:
    """Of a text: two built in, three by a matrix of numbers q = matrix @ x."""
    if kind == "relative":
        return Coordinates()
    if kind == "displacements":
        return Coordinates("lumped")
    if kind == "absolute":
        return Coordinates(matrix=[[1.0, 0.0], [-1.0, 1.0]], names=("phi_1", "phi_2"))
    matrix, names = np.zeros((6, 6)), list[str]()
    for j, s in enumerate(known["stages"]):
        e = np.eye(6)
        if kind == "spins":
            base, sun, planet = (e[0] if j else 0 * e[0]), e[3 * j + 1], e[3 * j + 2]
            sun, planet, turn = sun - base, base - planet, e[3 * j] - base
            names += [f"phi_{j + 1}", f"sun_{j + 1}", f"planet_{j + 1}"]
        else:
            sun, planet, turn = e[3 * j], e[3 * j + 1], e[3 * j + 2]
            names += [f"sun_{j + 1}", f"planet_{j + 1}", f"theta_{j + 1}"]
        matrix[3 * j] = s.r_s * sun - s.r_p * planet - s.r_cp * turn
        matrix[3 * j + 1] = s.r_p * planet - s.r_cp * turn
        matrix[3 * j + 2] = turn
    return Coordinates("lumped", matrix=matrix, names=tuple(names))


compile_text = lru_cache(partial(compile, mode="exec"))  # of equations that many arms have


def written(kind: str, replaced: tuple[tuple[str, str], ...], arm: Arm) -> Equations:
    """The equations of a text, these pieces of it replaced.

    Raises ValueError for a piece that the text does not have.
    """
    text = RIGHT[kind]
    for old, new in replaced:
        if old not in text:
            raise ValueError(f"{old!r} is not in the text {kind!r}")
        text = text.replace(old, new)
    code, known = compile_text(text, kind), quantities(arm)
    n = 2 if kind in RIGID else 6
    functions = {"sin": math.sin, "cos": math.cos, "sqrt": math.sqrt, "outer": np.multiply.outer}

    def answer(part: str, x: np.ndarray, v: np.ndarray, T: np.ndarray) -> np.ndarray:
        own = {**functions, **known, "x": x, "v": v, "T": T, "e": units}
        own |= {"M": np.zeros((n, n)), "h": np.zeros(n), "f": np.zeros(n)}

        def spin(inertia: float, row: np.ndarray) -> None:
            if part == "M":
                own["M"] += inertia * row[:, None] * row

        own["spin"] = spin
        exec(code, own)
        return own[part]

    still, free, units = np.zeros(n), np.zeros(2), np.eye(n)
    return Equations(
        mass_matrix=lambda x: answer("M", x, still, free),
        bias=lambda x, v: answer("h", x, v, free),
        force=lambda x, v, torque: answer("f", x, v, torque),
        coordinates=coordinates(kind, known),
        level="links" if kind in RIGID else "",
    )
