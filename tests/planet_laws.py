"""How far a geared model is off what single planets must do, from first principles.

Judged by ``tests.planet_meshes``, at random states with every mesh in or around its backlash.
"""

from collections.abc import Callable, Iterator

import numpy as np
import xarray as xr
from scipy.linalg import eigh

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.stiffness import StiffnessLaw
from crosscheck.models.interface import Model
from tests import arms
from tests.mixed_arms import LAWS, NONE, Data, arm_of, direct, geared, random_states
from tests.planet_meshes import Contact, contacts, expected_force, mean_stiffness, stiffness_at

FELT = 1e3  # times displacements' rates, at which dampers push as springs do


def unlike_arm() -> Arm:
    """Two stages in free fall whose planets differ in everything; no planet meshes in phase.

    28 sun teeth do not pass by three planets, nor 31 by four; 15 1/2 pitches lie between the flanks
    of the shoulder's planets and 15 whole ones between those of the elbow's.
    """
    dice, joints = arms.roll_dice(2828), []  # every law, damping and form of phases is among them
    for sun, planet, count in ((28, 32, 3), (31, 31, 4)):
        teeth = {"sun_teeth": sun, "planet_teeth": planet, "ring_teeth": sun + 2 * planet}
        joints.append(geared(**teeth, planet_count=count))
        arms.part_planets(dice, joints[-1])
    return arm_of(*joints, gravity=NONE)


def odd_one_out(odd: int = 2) -> Arm:
    """Four planets alike but for the stiffness of one; those alike may be worked out at once."""
    laws = [LAWS["table" if n == odd else "square"] for n in range(4)]
    joint = geared(planet_count=4)
    for side in ("sun_mesh", "ring_mesh"):
        plain: Data = {"stiffness": laws, "backlash_m": 0.0, "tooth_error_m": 0.0}
        joint[side] = {**joint[side], **plain}
    return arm_of(joint, gravity=NONE)


def standing_errors() -> Arm:
    """One stage, its planets alike, with errors that stand still."""
    joint = geared()
    for side, static in (("sun_mesh", -6e-6), ("ring_mesh", 7e-6)):
        joint[side] = {**joint[side], "static_error_m": static}
    return arm_of(joint, gravity=NONE)


def alike_planets() -> Arm:
    """Every law of stiffness, a direct joint between, weight, the planets of a stage alike."""
    return arm_of(geared("table", "fourier"), direct(), geared("square", "sine"))


ARMS = {
    "unlike planets": unlike_arm,
    "alike planets": alike_planets,
    "standing errors": standing_errors,
}
OFFSETS = {  # of the start
    "sun_planet_offset_m": [3e-6, 5e-6],
    "planet_ring_offset_m": [2e-5, 4e-6],
    "planet_offset_m": [[1e-6, -2e-6, 3e-6], [-9e-6, 5e-6, 0.0, -4e-6]],
}


def _states(model: Model, count: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    for q, v in random_states(model.layout, count):
        yield q, np.where(model.layout.angular, 1.0, FELT) * v


def _off(model: Model, found: np.ndarray, expected: np.ndarray) -> float:
    """Of angles and of displacements, each over the largest of its kind; of all if it is none."""
    kinds = (model.layout.angular, ~model.layout.angular)
    sizes = [abs(expected[kind]).max() or abs(expected).max() for kind in kinds]
    off = abs(found - expected)
    return max(float(off[kind].max() / size) for kind, size in zip(kinds, sizes, strict=True))


def force_off(model: Model, count: int = 3, t: float = 0.0) -> float:
    """The generalized force off what the laws say, of its size; without drive and weight."""
    of = (model.arm, model.switches, model.layout)
    return max(
        _off(model, model.generalized_force(t, q, v), expected_force(*of, t, q, v))
        for q, v in _states(model, count)
    )


def motion_off(model: Model, count: int = 3) -> float:
    """M a + bias off the force that the laws say, of its size."""
    worst = 0.0
    for q, v in _states(model, count):
        found = model.mass_matrix(q) @ model.acceleration(0.0, q, v) + model.bias(q, v)
        expected = expected_force(model.arm, model.switches, model.layout, 0.0, q, v)
        worst = max(worst, _off(model, found, expected))
    return worst


def in_step(lumped: Model, free: Model) -> np.ndarray:
    """T of q_free = T q_lumped: x_s = x_sp + x_pr, and every x_pr the same."""
    T = np.zeros((len(free.layout), len(lumped.layout)))
    for row, c in enumerate(free.layout.coordinates):
        meanings = ("x_sp", "x_pr") if c.meaning == "x_s" else (c.meaning,)
        T[row, [lumped.layout.at(meaning, c.joint - 1) for meaning in meanings]] = 1.0
    return T


def in_step_off(free: Model, count: int = 3) -> float:
    """Lumped planets off free ones in step: mass, bias, force, acceleration, of their sizes."""
    laws = free.switches.model_copy(update={"planets": "lumped"})
    lumped = type(free)(free.arm, free.scenario, laws)
    T, worst = in_step(lumped, free), 0.0
    for q, v in random_states(lumped.layout, count):
        one, other = (0.1, q, v), (0.1, T @ q, T @ v)
        for together, one_by_one in (
            (lumped.mass_matrix(q), T.T @ free.mass_matrix(T @ q) @ T),
            (lumped.bias(q, v), T.T @ free.bias(*other[1:])),
            (lumped.generalized_force(*one), T.T @ free.generalized_force(*other)),
            (T @ lumped.acceleration(*one), free.acceleration(*other)),
        ):
            worst = max(worst, float(abs(one_by_one - together).max() / abs(together).max()))
    return worst


def first_touch(model: Model) -> Iterator[tuple[list[float], list[float]]]:
    """x_sp and x_pr [m] of each geared joint's planets at the start, with its offsets.

    In contact every planet touches the ring, and the sun the first planet that it meets.
    """
    start = model.scenario.start
    found = contacts(model.arm, model.switches, model.layout)
    for joint in model.layout.mesh_joints:
        planets = range(model.arm.joints[joint].planet_count)
        own = [each.mesh for each in found if each.angle == model.layout.at("theta", joint)]
        touches = start.mesh == "contact"
        on_sun, on_ring = (
            [touches * (mesh.backlash_m + mesh.static_error_m) for mesh in own[side::2]]
            for side in (0, 1)
        )
        sun = min(at + ring for at, ring in zip(on_sun, on_ring, strict=True))
        of_sun, of_ring = (
            given[joint] if isinstance(given, tuple) else given
            for given in (start.sun_planet_offset_m, start.planet_ring_offset_m)
        )
        apart = start.planet_offset_m[joint] if start.planet_offset_m else (0.0,) * len(planets)
        x_pr = [on_ring[n] + of_ring + apart[n] for n in planets]
        yield [sun + of_sun + of_ring - x_pr[n] for n in planets], x_pr


def start_off(model: Model) -> float:
    """Displacements of the first record off those of the start [m]."""
    first = model.simulate().isel(time=0)
    worst = 0.0
    for joint, expected in zip(model.layout.mesh_joints, first_touch(model), strict=True):
        for name, own in zip(("x_sp", "x_pr"), expected, strict=True):
            found = first[name].values[joint, : len(own)]
            worst = max(worst, float(abs(found - own).max()))
    return worst


def records_off(model: Model) -> float:
    """Forces of a run's records off those of the recorded displacements, of their size."""
    run = model.simulate()
    worst = 0.0
    for joint, planet, name, contact in _recorded(model):
        x = run[f"x_{name}"].values[:, joint, planet]
        expected = spring_force(contact, x, run.theta.values[:, joint])
        found = run[f"F_{name}"].values[:, joint, planet]
        worst = max(worst, float(abs(found - expected).max() / abs(run[f"F_{name}"]).max()))
    return worst


def _recorded(model: Model) -> Iterator[tuple[int, int, str, Contact]]:
    found = iter(contacts(model.arm, model.switches, model.layout))
    for joint in model.layout.mesh_joints:
        for planet in range(model.arm.joints[joint].planet_count):
            yield joint, planet, "sp", next(found)
            yield joint, planet, "pr", next(found)


def spring_force(contact: Contact, x: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """k f [N] along a motion, shape (times,)."""
    phases = [contact.phase_at(angle) for angle in theta]
    return np.array(
        [
            stiffness_at(contact.mesh.stiffness, phase) * contact.reach(at, phase)
            for at, phase in zip(x, phases, strict=True)
        ]
    )


def energies(model: Model, run: xr.Dataset) -> np.ndarray:
    """Of the springs [J] at every record, phases by the angles."""
    total = np.zeros(run.sizes["time"])
    for joint, planet, name, contact in _recorded(model):
        x, theta = run[f"x_{name}"].values[:, joint, planet], run.theta.values[:, joint]
        for record, (at, angle) in enumerate(zip(x, theta, strict=True)):
            phase = contact.phase_at(angle)
            reach = contact.reach(at, phase)
            total[record] += stiffness_at(contact.mesh.stiffness, phase) * reach**2 / 2
    return total


def spring_matrix(model: Model, stiffness: Callable[[StiffnessLaw], float]) -> np.ndarray:
    """K [N/m], shape (n, n), of every mesh in contact, each with what its law has."""
    K = np.zeros((len(model.layout), len(model.layout)))
    for contact in contacts(model.arm, model.switches, model.layout):
        K += stiffness(contact.mesh.stiffness) * np.outer(contact.row, contact.row)
    return K


def modes_off(model: Model) -> float:
    """Frequencies with every tooth in contact at mean stiffness, off those of M and K."""
    mass = model.mass_matrix(np.zeros(len(model.layout)))
    squares = eigh(spring_matrix(model, mean_stiffness), mass, eigvals_only=True)
    of_meshes = squares[len(model.arm.joints) :]
    return float(abs(model.mesh_modes() * 2 * np.pi / np.sqrt(of_meshes) - 1).max())
