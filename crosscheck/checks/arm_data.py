"""Checks of one model's inertia and force against the data of arm and experiment."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from crosscheck.checks.answers import (
    MethodQuestion,
    Setting,
    States,
    generalized_force,
    mass_matrix,
)
from crosscheck.checks.energy import springs_at
from crosscheck.checks.first_principles import composite
from crosscheck.checks.sampled import DIFFERENCE, SampledArm, Subjects
from crosscheck.checks.scales import geared_joints, mesh_damping, motor_forces
from crosscheck.checks.states import compare_answers
from crosscheck.findings import Finding, Subject
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import MESHES, Layout
from crosscheck.models.experiment.scenario import (
    ConstantDrive,
    PdDrive,
    Scenario,
    SinusoidDrive,
    Switches,
    expand_to_joints,
)
from crosscheck.planning.comparison import Comparison


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons of each model's force and inertia with the data of arm and experiment.

    The inertia of a form of the paper is none of real bodies.
    """
    for arm in subjects.arms:
        if arm.owes_laws and arm.group != "form":
            yield _plan(arm, _check_inertia, mass_matrix)
        if arm.owes_laws:
            yield _plan(arm, _check_force, generalized_force)


def _plan(arm: SampledArm, law: Callable[..., Finding], question: MethodQuestion) -> Comparison:
    judge, metric = partial(law, content=arm.content), arm.over(DIFFERENCE)
    against = "the arm's data"
    return arm.plan_law(question.method, [question], judge, metric, against, family="arm-data")


def _check_inertia(
    about: Subject, mass: np.ndarray, setting: Setting, content: composite.Content
) -> Finding:
    """Check M (count, n, n) by the parallel axis theorem and the turns of gears."""
    parts = composite.build_parts(content, setting.level or "coupled")
    pose = composite.arm_pose(content, setting.states.q[:, setting.layout.theta])
    expected = composite.mass_matrix(parts, pose, setting.layout)
    return compare_answers(about, expected, mass, setting)


def _check_force(
    about: Subject, force: np.ndarray, setting: Setting, content: composite.Content
) -> Finding:
    """Check a force (count, n): drive, friction, weight of all that a joint carries, and the teeth.

    With the teeth at rest no mesh does work on a joint, and a motor turns the link alone.
    """
    arm, scenario, laws = setting.case
    layout, parts = setting.layout, composite.build_parts(content, setting.level or "coupled")
    friction = np.array([float(j.get("friction_N_m_s_per_rad", 0.0)) for j in content["joints"]])
    pose = composite.arm_pose(content, setting.states.q[:, layout.theta])
    pulled, expected = composite.weight(parts, pose, content), np.zeros_like(force)
    t, q, v = setting.states
    theta, rates = q[:, layout.theta], v[:, layout.theta]
    torques = drive_torques(scenario, t, theta, rates)
    expected[:, layout.theta] = torques + pulled - friction * rates
    if layout.mesh_joints:
        expected += motor_forces(arm, layout, torques)
        expected += teeth_forces(arm, laws, layout, setting.states)
    return compare_answers(about, expected, force, setting)


def drive_torques(
    scenario: Scenario, t: np.ndarray, theta: np.ndarray, theta_dot: np.ndarray
) -> np.ndarray:
    """Output-side torques [N m], (states, joints), by the scenario's fields; t (states,) [s]."""
    drive, joints = scenario.drive, theta.shape[1]

    def expand(value: float | tuple[float, ...]) -> np.ndarray:
        return np.array(expand_to_joints(value, joints))

    if isinstance(drive, ConstantDrive):
        return np.broadcast_to(expand(drive.torque_N_m), theta.shape)
    if isinstance(drive, PdDrive):
        away = expand(drive.target_rad) - theta
        damped = expand(drive.derivative_N_m_s_per_rad) * theta_dot
        return expand(drive.proportional_N_m_per_rad) * away - damped
    if isinstance(drive, SinusoidDrive):
        argument = t[:, None] if drive.argument == "time" else t[:, None] ** 0.5
        return expand(drive.amplitude_N_m) * np.sin(expand(drive.rate_rad_per_s) * argument)
    return np.array([np.interp(t, drive.time_s, column) for column in drive.torque_N_m]).T


def teeth_forces(arm: Arm, chosen: Switches, layout: Layout, states: States) -> np.ndarray:
    """Forces of springs and dampers of all meshes on the coordinates, shape (count, n).

    They are those of the exact dead zone, dampers that always act and phases by the angle.
    """
    forces, contacts = np.zeros_like(states.q), springs_at(arm, chosen, layout, states.q)
    for number, joint in geared_joints(arm):
        for planet in range(joint.planet_count):
            for name in MESHES:
                spring, row = next(contacts), layout.displacement(name, number, planet)
                pressed = spring.gap - np.clip(spring.gap, -spring.backlash, spring.backlash)
                damped = mesh_damping(joint, name, planet) * (states.v @ row)
                force = spring.stiffness * pressed + damped
                forces -= force[:, None] * row
    return forces
