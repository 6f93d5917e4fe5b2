"""Gear meshes of the Exudyn tree: the force law of each, compiled, on the tree's coordinates.

Seen from the carrier every planet turns about a fixed axis, so the belts along the two lines of
action give, with w the rotation of the central wheel and p that of the planet, both relative to
the carrier, and R and r the base radii,

    external mesh with the sun:   x = R w + r p
    internal mesh with the ring:  x = R w - r p

x > 0 when the teeth press on the side that drives the carrier forward. One law covers both, with a
signed planet radius. (Eq. n) refers to the paper the arm is taken from.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.models.exudyn.tree.stiffness import Number, StiffnessCurve, stiffness_at
from crosscheck.models.numba_cache import njit

NO_SUN = -1  # number in place of a sun's coordinate
STEP = 1e-50  # of an angle's imaginary part: nothing beside 1, and so is its square beside it


class MeshLaw(NamedTuple):
    """One mesh in SI units; ``array`` lays it out for the compiled functions in this order.

    wheel_radius, planet_radius: base radii of the deflection above, the latter negative for the
    ring. damping [N s/m]: of this one mesh, 1/N of the stage's. smooth, damped_in_contact_only and
    clock_phase are switches, 1.0 or 0.0. From tooth_error on: all that ``variation`` reads, where
    phase_rate is radians of mesh phase per radian of joint angle, and curve the stiffness.
    """

    wheel_radius: float
    planet_radius: float
    backlash: float
    damping: float
    sharpness: float
    smooth: float
    damped_in_contact_only: float
    tooth_error: float
    error_phase: float
    static_error: float
    phase_rate: float
    phase_offset: float
    clock_phase: float
    curve: StiffnessCurve

    @property
    def array(self) -> np.ndarray:
        """The fields as float64, those of the curve from place CURVE on."""
        return np.concatenate([self[:CURVE], self.curve.array])


_FIELDS = {name: place for place, name in enumerate(MeshLaw._fields)}
WHEEL_RADIUS, PLANET_RADIUS = _FIELDS["wheel_radius"], _FIELDS["planet_radius"]
BACKLASH, DAMPING = _FIELDS["backlash"], _FIELDS["damping"]
SHARPNESS, SMOOTH = _FIELDS["sharpness"], _FIELDS["smooth"]
CONTACT_ONLY, ERROR = _FIELDS["damped_in_contact_only"], _FIELDS["tooth_error"]
ERROR_PHASE, STATIC = _FIELDS["error_phase"], _FIELDS["static_error"]
RATE, OFFSET = _FIELDS["phase_rate"], _FIELDS["phase_offset"]
BY_CLOCK, CURVE = _FIELDS["clock_phase"], _FIELDS["curve"]


@njit(cache=True)
def clearance(x: float, b: float) -> float:
    """Eq. 5: f_k [m] of a deflection x [m] in a clearance 2 b [m]."""
    if x > b:
        return x - b
    if x <= -b:
        return x + b
    return 0.0


@njit(cache=True)
def smooth_clearance(x: float, b: float, sharpness: float) -> float:
    """Eq. 6: f_k [m] with tanh corners of the given sharpness [1/m]."""
    upper, lower = np.tanh(sharpness * (x - b)), np.tanh(sharpness * (x + b))
    return x + x / 2 * (upper - lower) - b / 2 * (upper + lower)


@njit(cache=True)
def variation(law: np.ndarray, t: float, theta: Number, theta_dot: float) -> tuple[Number, Number]:
    """k [N/m] and e [m] at time t [s], joint angle [rad] and rate [rad/s] (Eqs. 8, 14)."""
    angle = theta_dot * t if law[BY_CLOCK] else theta
    phase = law[RATE] * angle + law[OFFSET]
    sine = np.sin(phase)
    runout = np.sin(phase + law[ERROR_PHASE]) if law[ERROR_PHASE] else sine
    return stiffness_at(law, CURVE, phase, sine), law[STATIC] + law[ERROR] * runout


@njit(cache=True)
def elastic_force(law: np.ndarray, x: float, stiffness: float, error: float) -> float:
    """Spring force [N] along the line of action (Eqs. 4, 8, 14, 15)."""
    gap = x - error
    if law[SMOOTH]:
        travel = smooth_clearance(gap, law[BACKLASH], law[SHARPNESS])
    else:
        travel = clearance(gap, law[BACKLASH])
    return stiffness * travel


@njit(cache=True)
def damping_force(law: np.ndarray, x: float, x_dot: float, error: float) -> float:
    """Damper force [N] along the line of action."""
    if law[CONTACT_ONLY] and abs(x - error) <= law[BACKLASH]:
        return 0.0
    return law[DAMPING] * x_dot


@njit(cache=True)
def stretch(law: np.ndarray, wheel: float, planet: float, carrier: float) -> float:
    """x [m] of angles [rad], or x' [m/s] of rates.

    wheel and carrier turn relative to the previous link, planet relative to the carrier.
    """
    return law[WHEEL_RADIUS] * (wheel - carrier) + law[PLANET_RADIUS] * planet


@njit(cache=True)
def turning_torque(law: np.ndarray, x: float, stiffness: complex, error: complex) -> float:
    """-dV/dtheta [N m] of V = k (f_k)^2 / 2, x held: what the spring's potential does to the link.

    The slope of V itself, by a complex step: V(theta + i h) = V + i h dV/dtheta, and h^2 is
    nothing. stiffness, error: of ``variation`` at theta + i STEP. For the exact clearance and
    phases by the angle.
    """
    gap = x - error
    travel = complex(clearance(gap.real, law[BACKLASH]), gap.imag)  # f_k' = 1, or f_k is 0
    potential = stiffness * travel * travel / 2
    return -potential.imag / STEP


class TreeMesh(NamedTuple):
    """The mesh of a planet, counted from 0 on its link, and places of what it couples.

    wheel: the sun, or NO_SUN of a ring mesh, which the previous link bears.
    """

    law: MeshLaw
    number: int
    link: int
    wheel: int
    planet: int


class Gearing(NamedTuple):
    """All meshes of a tree as flat arrays.

    laws (meshes, longest law): MeshLaw.array, zeros behind it; places (meshes, 3): link, wheel and
    planet; conservative: whether the springs' potential acts on links; whole: whether suns' and
    planets' angles are all that they turn, not only what they turn beyond rigid gears.
    """

    laws: np.ndarray
    places: np.ndarray
    conservative: bool
    whole: bool


def build_gearing(meshes: Sequence[TreeMesh], conservative: bool, whole: bool) -> Gearing:
    """All meshes of a tree as flat arrays."""
    places = np.array([mesh[2:] for mesh in meshes], dtype=np.int64).reshape(-1, 3)
    return Gearing(_rows([mesh.law.array for mesh in meshes]), places, conservative, whole)


def _rows(arrays: Sequence[np.ndarray]) -> np.ndarray:
    rows = np.zeros((len(arrays), max((array.size for array in arrays), default=0)))
    for row, array in zip(rows, arrays, strict=True):
        row[: array.size] = array
    return rows


@njit(cache=True)
def stretch_motion(
    law: np.ndarray, q: np.ndarray, q_t: np.ndarray, link: int, sun: int, planet: int, whole: bool
) -> tuple[float, float]:
    """x [m] and x' [m/s] of a mesh by the tree's coordinates and rates; whole: see Gearing."""
    wheel, wheel_t = (0.0, 0.0) if sun == NO_SUN else (q[sun], q_t[sun])
    x = stretch(law, wheel, q[planet], q[link] if whole else 0.0)
    return x, stretch(law, wheel_t, q_t[planet], q_t[link])


@njit(cache=True)
def add_mesh(
    law: np.ndarray,
    t: float,
    q: np.ndarray,
    q_t: np.ndarray,
    link: int,
    sun: int,
    planet: int,
    conservative: bool,
    whole: bool,
    forces: np.ndarray,
) -> None:
    """Add spring and damper of one mesh at time t [s] to the forces [N m] of what it couples.

    If conservative also what the spring's potential does to the link. Its coordinate is its angle
    against the previous link: that is a pair of torques between both.
    """
    x, x_dot = stretch_motion(law, q, q_t, link, sun, planet, whole)
    stiffness, error = variation(law, t, q[link], q_t[link])
    pull = elastic_force(law, x, stiffness, error) + damping_force(law, x, x_dot, error)
    forces[link] += law[WHEEL_RADIUS] * pull
    forces[planet] -= law[PLANET_RADIUS] * pull
    if sun != NO_SUN:
        forces[sun] -= law[WHEEL_RADIUS] * pull
    if conservative:
        turned = variation(law, 0.0, complex(q[link], STEP), 0.0)
        forces[link] += turning_torque(law, x, turned[0], turned[1])


@njit(cache=True, inline="always")
def add_meshes(
    gears: Gearing, t: float, q: np.ndarray, q_t: np.ndarray, forces: np.ndarray
) -> None:
    """Add all meshes at time t [s] to the forces [N m] of the coordinates."""
    for row in range(len(gears.places)):
        law, places = gears.laws[row], gears.places
        link, sun, planet = places[row, 0], places[row, 1], places[row, 2]
        add_mesh(law, t, q, q_t, link, sun, planet, gears.conservative, gears.whole, forces)


@njit(cache=True)
def read_meshes(gears: Gearing, t: np.ndarray, q: np.ndarray, q_t: np.ndarray) -> np.ndarray:
    """x [m], x' [m/s] and spring force [N] of all meshes, shape (3, meshes, times).

    Along t (times,) [s], coordinates q and rates q_t (times, bodies).
    """
    read = np.empty((3, len(gears.places), len(t)))
    for row in range(len(gears.places)):
        law = gears.laws[row]
        link, sun, planet = gears.places[row]
        for time in range(len(t)):
            x, x_dot = stretch_motion(law, q[time], q_t[time], link, sun, planet, gears.whole)
            stiffness, error = variation(law, t[time], q[time, link], q_t[time, link])
            read[0, row, time] = x
            read[1, row, time] = x_dot
            read[2, row, time] = elastic_force(law, x, stiffness, error)
    return read
