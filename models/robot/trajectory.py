"""A robot's run as the Dataset of an arm's: over time, joint and, for stages, planet."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.models.arm.layout import MESHES
from crosscheck.models.experiment.drive import drive_data, torques_along
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.robot.file import RobotSource
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import MESH_LAWS, Robot
from crosscheck.models.trajectory import SCHEMA_VERSION, dataset_of, recorded_times

if TYPE_CHECKING:
    import xarray as xr


def build_robot_trajectory(
    model: RobotModel, scenario: Scenario, q: np.ndarray, v: np.ndarray
) -> xr.Dataset:
    """The Dataset of a run with coordinates and rates q, v (records, n).

    Joints are all that move, in the robot's order; one that follows another has no torque of its
    own. What its own gears have is NaN where a joint has none. Values that are no state come from
    the model: accelerations, elastic forces, which are what holds the meshes at rest, and energy.
    """
    robot, time = model.robot, recorded_times(scenario)
    free, count = list(robot.coordinates), len(robot.joints)
    given = drive_data(scenario, len(free), robot.motors)
    torques = torques_along(given, time, q[:, : len(free)], v[:, : len(free)])
    a = model.forward_dynamics(q, v, torques)
    still = np.zeros_like(q)
    follows, offsets = robot.joint_map
    whole = np.zeros((len(time), count))
    whole[:, free] = torques
    angles, rates, growth = (x[:, : len(free)] @ follows.T for x in (q, v, a))
    variables = {
        "theta": angles + offsets,
        "theta_dot": rates,
        "theta_ddot": growth,
        "torque": whole,
        "kinetic_energy": model.energy(q, v) - model.energy(q, still),
    }
    if model.level == "geared":
        variables |= _mesh_variables(model, q, v)
    name = f"{model.name}:{model.level}"
    return make_robot_dataset(name, robot, scenario, time, variables)


def make_robot_dataset(
    name: str,
    robot: Robot,
    scenario: Scenario,
    time: np.ndarray,
    variables: dict[str, np.ndarray],
) -> xr.Dataset:
    """The Dataset of a run, by a model of this name, of a robot in an experiment."""
    source = RobotSource(file=robot.content, urdf_text=robot.urdf)
    provenance = {
        "model": name,
        "schema_version": SCHEMA_VERSION,
        "step_s": scenario.step_s,
        "robot": source.model_dump_json(),
        "scenario": json.dumps(scenario.model_dump()),
        "switches": MESH_LAWS.model_dump_json(),
        "joints": json.dumps([joint.name for joint in robot.joints]),
        "kinds": json.dumps([joint.kind for joint in robot.joints]),
    }
    return dataset_of(variables, time, provenance, len(robot.joints))


def _mesh_variables(model: RobotModel, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
    """Displacements, rates and elastic forces of rotors' meshes and of every planet of stages."""
    robot = model.robot
    place, count = len(robot.coordinates), len(robot.joints)
    variables: dict[str, np.ndarray] = {}
    if robot.meshes:
        force = model.inverse_dynamics(q, 0 * q, 0 * q) - model.gravity(q)
        for name in ("x_mesh", "x_mesh_dot", "F_mesh"):
            variables[name] = np.full((len(q), count), np.nan)
        for rotor, _ in robot.meshes:
            for name, values in (("x_mesh", q), ("x_mesh_dot", v), ("F_mesh", force)):
                variables[name][:, rotor.joint] = values[:, place]
            place += 1
    planets = max((stage.gears.planet_count for stage in robot.stages), default=0)
    for side in ("sp", "pr") if planets else ():
        for name in (f"x_{side}", f"x_{side}_dot", f"F_{side}"):
            variables[name] = np.full((len(q), count, planets), np.nan)
    forces = iter(model.stage_forces(q).T if robot.stages else ())
    for stage, columns in zip(robot.stages, robot.stage_columns, strict=True):
        for planet in range(stage.gears.planet_count):
            for side in MESHES:
                row = stage.displacement(side, planet)
                at = slice(None), stage.joint, planet
                variables[side][at] = q[:, columns] @ row
                variables[f"{side}_dot"][at] = v[:, columns] @ row
                variables[side.replace("x", "F")][at] = next(forces)
    return variables
