"""Effects that rigid gears omit: backlash, wind-up, vibration and the tip's deviation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crosscheck.analytic.robot.springs import mesh_rates, tooth_springs
from crosscheck.cost.motion import RobotMotion, State
from crosscheck.models.robot.integration import integrate
from crosscheck.models.robot.interface import RobotModel

RESOLVED = 0.4  # phase of the fastest vibration in one step of a run [rad]


@dataclass(frozen=True)
class MeshCost:
    """The yield of a mesh's teeth along a motion, in rad or m at their joint.

    name: such as `sun mesh of elbow`; backlash: their part of the joint's while the motor is held;
    windup: largest deflection of the teeth under the torques of level coupled; slowest, fastest
    [Hz]: vibrations of the mesh while other joints' meshes are open. A stage has two vibrations,
    the faster one listed with its sun mesh.
    """

    name: str
    joint: str
    unit: str
    backlash: float
    windup: float
    slowest: float
    fastest: float


@dataclass(frozen=True)
class GearedCost:
    """Effects of the level geared that the level coupled omits.

    distances (runs,) [m]: from the plan to the end effector after a second under the torques of
    level coupled, infinite where a run diverged; None if a run needs more steps than allowed.
    """

    meshes: tuple[MeshCost, ...]
    steps: int
    distances: np.ndarray | None


def compute_geared_cost(
    coupled: RobotModel,
    geared: RobotModel,
    motion: RobotMotion,
    instants: int,
    runs: int,
    most_steps: int,
) -> GearedCost:
    """Effects that level coupled omits along a motion, without runs if they need too many steps."""
    state = motion.at(motion.instants(instants))
    force = _forces(coupled, geared, state)
    masses = geared.mass_matrix(np.hstack([state[0], 0 * force]))
    rates, costs = mesh_rates(geared.robot, masses), []
    for mesh_force, swings, spring in zip(
        force.T, rates.swings.T, tooth_springs(geared.robot), strict=True
    ):
        joint, lever = geared.robot.joints[spring.joint], abs(spring.lever)
        costs.append(
            MeshCost(
                spring.name,
                joint.name,
                "rad" if joint.kind == "revolute" else "m",
                2 * spring.backlash / lever,
                float(np.abs(mesh_force).max()) / spring.stiffness / lever,
                float(swings.min()) / (2 * np.pi),
                float(swings.max()) / (2 * np.pi),
            )
        )
    steps = int(np.ceil(rates.fastest / RESOLVED))
    able = steps <= most_steps
    distances = _compute_distances(coupled, geared, motion, runs, steps) if able else None
    return GearedCost(tuple(costs), steps, distances)


def _compute_distances(
    coupled: RobotModel, geared: RobotModel, motion: RobotMotion, runs: int, steps: int
) -> np.ndarray:
    """Distances (runs,) [m] of the end effector from the plan after a second at level geared.

    In each run the mesh starts at rest, each tooth on the flank that the torque loads.
    """
    starts = motion.instants(runs, before_end=1.0)
    state = motion.at(starts)
    x = _forces(coupled, geared, state)
    for column, spring in zip(x.T, tooth_springs(geared.robot), strict=True):
        column[:] = np.sign(column) * spring.backlash + column / spring.stiffness
    ends, _ = integrate(
        geared,
        np.hstack([state[0], x]),
        np.hstack([state[1], 0 * x]),
        lambda after: motor_torques(coupled, motion.at(starts + after)),
        1.0,
        steps,
    )
    return tip_distances(geared, ends, coupled.tip(motion.at(starts + 1.0)[0]))


def motor_torques(model: RobotModel, state: State) -> np.ndarray:
    """Torques (states, n) of a motion, 0 where no motor exerts them."""
    torques = model.inverse_dynamics(*state)
    torques[:, model.robot.passive] = 0.0
    return torques


def tip_distances(model: RobotModel, ends: np.ndarray, planned: np.ndarray) -> np.ndarray:
    """Distances (runs,) [m] of the end effector from its plan (runs, 3), infinite if diverged."""
    distances, alive = np.full(len(ends), np.inf), np.isfinite(ends).all(axis=1)
    distances[alive] = np.linalg.norm(model.tip(ends[alive]) - planned[alive], axis=1)
    return distances


def _forces(coupled: RobotModel, geared: RobotModel, state: State) -> np.ndarray:
    """Force (instants, meshes) [N] on each mesh's wheel by motor and inertia, with rigid teeth."""
    torques, free = motor_torques(coupled, state), geared.robot.coordinates
    still = np.zeros((len(torques), len(tooth_springs(geared.robot))))
    q, v, a = (np.hstack([each, still]) for each in state)
    needed = (geared.mass_matrix(q) @ a[:, :, None])[:, :, 0] + geared.bias(q, v)
    forces: np.ndarray = -needed[:, len(free) :]  # weights do no work on x
    for column, spring in zip(forces.T, tooth_springs(geared.robot), strict=True):
        if spring.joint in free:
            column += torques[:, free.index(spring.joint)] / spring.lever
    return forces
