"""What a rigid gear leaves out where teeth give way: backlash, wind-up, swings, the tip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crosscheck.cost.motion import RobotMotion
from crosscheck.cost.runs import away, mesh_rates, run
from crosscheck.models.robot.interface import RobotModel

RESOLVED = 0.4  # [rad] of the fastest swing in a step of a run
States = tuple[np.ndarray, np.ndarray, np.ndarray]  # coordinates, rates, accelerations


@dataclass(frozen=True)
class MeshCost:
    """Of a rotor's mesh along a motion, in rad or m at its joint.

    backlash: of the joint while the rotor is held; windup: the largest deflection of the teeth
    under the torques of coupled; slowest, fastest [Hz]: of its swings, other meshes in gear.
    """

    joint: str
    unit: str
    backlash: float
    windup: float
    slowest: float
    fastest: float


@dataclass(frozen=True)
class GearedCost:
    """What coupled leaves out of geared.

    distances (runs,) [m]: of the end effector from the plan after a second under coupled's torques,
    infinite where a run diverged; None if the steps that it asks for are more than allowed.
    """

    meshes: tuple[MeshCost, ...]
    steps: int
    distances: np.ndarray | None


def geared_cost(
    coupled: RobotModel,
    geared: RobotModel,
    motion: RobotMotion,
    instants: int,
    runs: int,
    most_steps: int,
) -> GearedCost:
    """Both models of one robot along a motion; what runs longer than most_steps is not run."""
    state = motion.at(motion.instants(instants))
    force = _forces(coupled, geared, state)
    masses = geared.mass_matrix(np.hstack([state[0], 0 * force]))
    rates, costs = mesh_rates(geared, masses), []
    for own, swings, (rotor, mesh) in zip(
        force.T, rates.swings.T, geared.robot.meshes, strict=True
    ):
        joint = geared.robot.joints[rotor.joint]
        lever = abs(rotor.ratio) * mesh.pinion_base_radius_m
        costs.append(
            MeshCost(
                joint.name,
                "rad" if joint.kind == "revolute" else "m",
                2 * mesh.backlash_m / lever,
                float(np.abs(own).max()) / mesh.stiffness_N_per_m / lever,
                float(swings.min()) / (2 * np.pi),
                float(swings.max()) / (2 * np.pi),
            )
        )
    steps = int(np.ceil(rates.fastest / RESOLVED))
    distances = None
    if steps <= most_steps:
        distances = _distances(coupled, geared, motion, runs, steps)
    return GearedCost(tuple(costs), steps, distances)


def _distances(
    coupled: RobotModel, geared: RobotModel, motion: RobotMotion, runs: int, steps: int
) -> np.ndarray:
    """From rest in the mesh, each tooth on the flank that the torques press."""
    starts = motion.instants(runs, before_end=1.0)
    state = motion.at(starts)
    x = _forces(coupled, geared, state)
    for column, (_, mesh) in zip(x.T, geared.robot.meshes, strict=True):
        column[:] = np.sign(column) * mesh.backlash_m + column / mesh.stiffness_N_per_m
    ends = run(
        geared,
        np.hstack([state[0], x]),
        np.hstack([state[1], 0 * x]),
        lambda after: coupled.inverse_dynamics(*motion.at(starts + after)),
        1.0,
        steps,
    )
    return away(geared, ends, coupled.tip(motion.at(starts + 1.0)[0]))


def _forces(coupled: RobotModel, geared: RobotModel, state: States) -> np.ndarray:
    """Of each mesh on its wheel (instants, meshes) [N], teeth rigid: the motor's less inertia's."""
    torques, free = coupled.inverse_dynamics(*state), geared.robot.coordinates
    still = np.zeros((len(torques), len(geared.robot.meshes)))
    forces = -geared.inverse_dynamics(*(np.hstack([each, still]) for each in state))[:, len(free) :]
    for column, (rotor, mesh) in zip(forces.T, geared.robot.meshes, strict=True):
        if rotor.joint in free:
            torque = torques[:, free.index(rotor.joint)]
            column += torque / rotor.ratio / mesh.pinion_base_radius_m
    return forces
