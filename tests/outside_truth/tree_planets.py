"""A geared joint whose three planets differ in everything, and what its meshes do, by hand.

Its coordinates are x_s, x_pr of each planet, theta; no planet meshes in phase with another.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.mixed_arms import LAWS, PLANET_M, SUN_J, Data, geared, mean_stiffness, stiffness

TEETH = {"sun_teeth": 28, "planet_teeth": 32, "ring_teeth": 92, "planet_count": 3}
R_S = 0.0025 * 28 / 2 * np.cos(np.radians(20))
SIZE, PLANETS = 5, range(3)
TURN = 2 * np.pi


@dataclass(frozen=True)
class Teeth:
    """One planet's mesh: law, b, E, phase of E, static error, zeta, phase of the mesh [rad]."""

    law: str
    b: float
    error: float
    error_phase: float
    static: float
    zeta: float
    phase: float

    def runout(self, theta: float) -> float:
        """e [m]."""
        return self.static + self.error * np.sin(self._at(theta) + self.error_phase)

    def travel(self, x: float, theta: float, play: float = 1.0) -> float:
        """Eq. 5 of x - e [m], b times ``play``."""
        gap = x - self.runout(theta)
        return float(np.sign(gap) * max(abs(gap) - play * self.b, 0))

    def spring(self, x: float, theta: float) -> float:
        """k f [N]."""
        return stiffness(self.law, self._at(theta)) * self.travel(x, theta)

    def energy(self, x: float, theta: float, play: float) -> float:
        """k f^2 / 2 [J]."""
        return stiffness(self.law, self._at(theta)) * self.travel(x, theta, play) ** 2 / 2

    def damping(self, mass: float) -> float:
        """A third of 2 zeta sqrt(3 k mass) [N s/m]."""
        return 2 * self.zeta * np.sqrt(3 * mean_stiffness(self.law) * mass) / 3

    def _at(self, theta: float) -> float:
        return 92 * theta + self.phase


# Phases: of 28 sun teeth a planet is 28/3 pitches late, of 92 ring teeth 92/3 early; half a pitch
# lies between the flanks of a planet of 32 teeth.
SUN = (
    Teeth("sine", 4e-5, 2e-5, 0.3, 5e-6, 0.06, 0.0),
    Teeth("fourier", 6e-5, 1e-5, -1.2, -8e-6, 0.02, TURN * 2 / 3),
    Teeth("square", 3e-5, 3e-5, 2.1, 2e-6, 0.04, TURN / 3),
)
RING = (
    Teeth("table", 5e-5, 1.5e-5, 1.4, -4e-6, 0.03, TURN / 2),
    Teeth("sine", 2e-5, 2.5e-5, 0.0, 6e-6, 0.05, TURN / 6),
    Teeth("fourier", 7e-5, 0.5e-5, -0.7, 0.0, 0.01, TURN * 5 / 6),
)
MASSES = {"sun_mesh": SUN_J / R_S**2, "ring_mesh": 3 * PLANET_M}
SIDES = {"sun_mesh": SUN, "ring_mesh": RING}


def unlike(**changes: object) -> Data:
    """The joint, its phases from the teeth."""
    return geared(**{**TEETH, **{name: _mesh(side) for name, side in SIDES.items()}, **changes})


def directly_damped() -> Data:
    """The joint with the same damping, but given in N s/m."""
    joint = unlike()
    for name, side in SIDES.items():
        mesh = dict(_mesh(side))
        del mesh["damping_ratio"]
        joint[name] = {
            **mesh,
            "damping_N_s_per_m": [float(3 * t.damping(MASSES[name])) for t in side],
        }
    return joint


def undamped(play: float = 1.0) -> Data:
    """The joint without damping, its clearances times ``play``."""
    meshes = {
        name: {
            **_mesh(side),
            "damping_ratio": 0.0,
            "backlash_m": [play * teeth.b for teeth in side],
        }
        for name, side in SIDES.items()
    }
    return unlike(**meshes)


def _mesh(side: tuple[Teeth, ...]) -> Data:
    return {
        "stiffness": [LAWS[t.law] for t in side],
        "backlash_m": [t.b for t in side],
        "tooth_error_m": [t.error for t in side],
        "tooth_error_phase_rad": [t.error_phase for t in side],
        "static_error_m": [t.static for t in side],
        "phase_rad": "from-teeth",
        "damping_ratio": [t.zeta for t in side],
    }


def energy(q: np.ndarray, play: float = 1.0) -> float:
    """Of all springs of so many such joints [J]; q (joints * SIZE,), clearances times ``play``."""
    total = 0.0
    for x_s, *x_pr, theta in q.reshape(-1, SIZE):
        for n in PLANETS:
            total += SUN[n].energy(x_s - x_pr[n], theta, play)
            total += RING[n].energy(x_pr[n], theta, play)
    return total


def mesh_forces(q: np.ndarray, v: np.ndarray, in_contact_only: bool = False) -> np.ndarray:
    """Generalized force (SIZE,) of the meshes of one joint, no work on the phase."""
    force, theta = np.zeros(SIZE), q[4]
    for n in PLANETS:
        at_sun = pull(SUN[n], MASSES["sun_mesh"], q[0] - q[1 + n], v[0] - v[1 + n], theta)
        at_ring = pull(RING[n], MASSES["ring_mesh"], q[1 + n], v[1 + n], theta)
        if in_contact_only:
            at_sun *= SUN[n].travel(q[0] - q[1 + n], theta) != 0
            at_ring *= RING[n].travel(q[1 + n], theta) != 0
        force[0] -= at_sun
        force[1 + n] += at_sun - at_ring
    return force


def pull(teeth: Teeth, mass: float, x: float, x_dot: float, theta: float) -> float:
    """Spring and damper [N]."""
    return teeth.spring(x, theta) + teeth.damping(mass) * x_dot
