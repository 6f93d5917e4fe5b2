"""A double pendulum with two rotors, and its equations in closed form: an outside truth."""

from collections.abc import Callable

import numpy as np

from crosscheck.models.robot.robot import Robot
from crosscheck.trial.input.equations import Equations
from tests.robots import chains

M1, M2, L, C1, C2, J1, J2, ROTOR, N, G = 5.0, 3.0, 1.0, 0.5, 0.3, 0.4, 0.2, 0.02, 10.0, 9.8
SHOULDER, ELBOW = J1 + M1 * C1**2 + M2 * L**2, J2 + M2 * C2**2
COUPLED, REFLECTED = M2 * L * C2, N**2 * ROTOR

URDF = chains.urdf(
    chains.link("base"),
    chains.link("a", chains.Solid(M1, (C1, 0, 0), (0.1, 0, 0, J1, 0, J1))),
    chains.link("b", chains.Solid(M2, (C2, 0, 0), (0.1, 0, 0, J2, 0, J2))),
    chains.joint("j1", "base", "a"),
    chains.joint("j2", "a", "b", at=(L, 0, 0)),
)


def robot() -> Robot:
    """The pendulum, its rotors by ratios of 10."""
    rotors = {name: chains.geared(N, ROTOR) for name in ("j1", "j2")}
    return chains.robot(URDF, rotors, gravity_m_per_s2=[0.0, -G, 0.0])


def mass_matrix(q: np.ndarray, reflected: float = REFLECTED) -> np.ndarray:
    """M (2, 2) of the level armature."""
    wave = COUPLED * np.cos(q[1])
    first = SHOULDER + ELBOW + 2 * wave + reflected
    return np.array([[first, ELBOW + wave], [ELBOW + wave, ELBOW + reflected]])


def coriolis(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """C (2, 2) by Christoffel's symbols."""
    rates = np.array([[-v[1], -v[0] - v[1]], [v[0], 0.0]])
    return COUPLED * np.sin(q[1]) * rates


def bias(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """C v (2,)."""
    squares = np.array([-2 * v[0] * v[1] - v[1] ** 2, v[0] ** 2])
    return COUPLED * np.sin(q[1]) * squares


def gravity(q: np.ndarray, lever: float = L) -> np.ndarray:
    """Torques that hold the weights (2,)."""
    second = M2 * C2 * G * np.cos(q[0] + q[1])
    return np.array([(M1 * C1 + M2 * lever) * G * np.cos(q[0]) + second, second])


def force(q: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Torques of motors less those that hold the weights (2,)."""
    return torque - gravity(q)


def inverse_dynamics(q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Torques of a motion (2,)."""
    return mass_matrix(q) @ a + bias(q, v) + gravity(q)


def acceleration(q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Accelerations (2,)."""
    return np.linalg.solve(mass_matrix(q), torque - bias(q, v) - gravity(q))


def right(**others: Callable[..., object]) -> Equations:
    """The equations, some parts of them others."""
    parts = {"mass_matrix": mass_matrix, "bias": bias, "gravity": gravity}
    return Equations(**(parts | others))


def sizes(part: str, q: np.ndarray, v: np.ndarray, a: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """How large a part's entries are by nature, as Cauchy and Schwarz bound them."""
    mass = mass_matrix(q)
    root = np.sqrt(np.diag(mass))
    motion = np.sqrt(v @ mass @ v) * np.abs(v).sum()
    weight = 10.0 * np.sqrt(M1 + M2)
    lowest = np.linalg.eigvalsh(mass / np.outer(root, root))[0]
    given = np.linalg.norm(torque / root)
    found = {
        "mass_matrix": np.outer(root, root),
        "bias": root * motion,
        "gravity": root * weight,
        "force": root * weight + np.abs(torque),
        "inverse_dynamics": root * (motion + weight + np.sqrt(a @ mass @ a)),
        "acceleration": (motion + weight + given) / lowest / root,
    }
    return found[part]
