"""Invariants of any model of an arm: balances of power and momentum, joints that stay closed.

All use a model's own M, bias, force and acceleration on one side and first principles on the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.answers import ABILITIES
from crosscheck.checks.sampled import FIRST_PRINCIPLES, SampledArm, Subjects
from crosscheck.checks.scales import base_radius, geared_joints, weight_moments
from crosscheck.checks.states import Setting
from crosscheck.findings import Finding, Subject, make_check, make_failed_check, make_share_check
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import MESHES, Layout
from crosscheck.models.experiment.drive import drive_data, torques_along
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.interface import STATE_ABILITIES
from crosscheck.models.loading import Case
from crosscheck.planning.comparison import Comparison

# Powers of 1e4 N x 0.1 m/s whose forces carry the rounding of displacements (see states).
TOLERANCE = 1e-10
BASIS = "rounding of the forces, as for accelerations"
GAP_TOLERANCE = 1e-12


class StateValues(NamedTuple):
    """One model's values at states: M (count, n, n); bias, force and acceleration (count, n)."""

    mass_matrix: np.ndarray
    bias: np.ndarray
    generalized_force: np.ndarray
    acceleration: np.ndarray


class Motion(NamedTuple):
    """What moves an arm and how it moves, at all states: M a + bias, force and rates (states, n).

    summed: the magnitudes whose sum ``inertial`` is, |M| |a| + |bias|; their rounding stays.
    torques and passive (states, joints): motors, and moments of weight and friction [N m].
    """

    layout: Layout
    v: np.ndarray
    inertial: np.ndarray
    summed: np.ndarray
    force: np.ndarray
    torques: np.ndarray
    passive: np.ndarray


Balance = Callable[[Subject, StateValues, Setting, Case], Finding]


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons of each model with itself: its balances, its joints, and its abilities.

    A model must say of itself all that the registry says of it, for users ask the model.
    """
    for arm in subjects.arms:
        if arm.owes_laws:
            judge = partial(_check_abilities, promised=arm.promises)
            metric, against = "abilities missing", "declared capabilities"
            yield arm.plan_law("abilities", [ABILITIES], judge, metric, against)
        if arm.group in ("geared", "free", "form"):
            yield from plan_balances(arm)
        if arm.group == "geared" and "constraint_residual" in arm.promises:
            metric = f"largest gap, rate, acceleration or error of one, {arm.count} random states"
            questions, against = ["constraint_residual"], "closure of its joints"
            yield arm.plan_law("constraints", questions, check_constraints, metric, against)


def plan_balances(arm: SampledArm) -> Iterator[Comparison]:
    """Comparisons of power and angular momentum, from all that the model says of a state."""
    yield plan_balance(arm, "power", "W", check_power_balance)
    yield plan_balance(arm, "angular-momentum-rate", "N m", check_angular_momentum)


def plan_balance(arm: SampledArm, name: str, unit: str, law: Balance) -> Comparison:
    """The comparison of one balance of a model."""

    def judge(about: Subject, *answers: Any) -> Finding:
        return law(about, StateValues(*answers), arm.setting, arm.case)

    metric = arm.over("largest residual")
    return arm.plan_law(name, STATE_ABILITIES, judge, metric, FIRST_PRINCIPLES, unit=unit)


def _check_abilities(about: Subject, claimed: Any, promised: frozenset[str]) -> Finding:
    lacking = sorted(promised - set(claimed.tolist()))
    if lacking:
        return make_failed_check(about, f"the model does not claim to have {', '.join(lacking)}")
    return make_check(about, measured=0.0, tolerance=0.0, basis="every promised ability is there")


def check_power_balance(
    about: Subject, given: StateValues, setting: Setting, case: Case
) -> Finding:
    """Check d(kinetic)/dt = sum of T theta_s' / n + powers of meshes, dampers, weight, friction.

    A motor turns its sun n times as fast as the link, and by the mesh displacements; its torque
    reaches a mesh row of the force as T / (n r_s).
    """
    motion = compute_motion(given, setting, case.scenario)
    powers = [external_powers(setting.arm, motion)]
    for number, joint in geared_joints(setting.arm):
        radius, ratio = sun_radius_and_ratio(joint)
        advance = sun_advance(motion.layout, number)
        motor = motion.torques[:, number, None] / ratio * advance / radius
        rows = displacement_places(motion.layout, number)
        powers.append(((motion.force - motor) * motion.v)[:, rows])
    return check_powers(about, motion, np.hstack(powers))


def check_angular_momentum(
    about: Subject, given: StateValues, setting: Setting, case: Case
) -> Finding:
    """Check that the whole arm's angular momentum changes by what the ground exerts."""
    motion = compute_motion(given, setting, case.scenario)
    return check_balance(about, *_angular_momentum_residual(setting.arm, motion))


def check_powers(about: Subject, motion: Motion, powers: np.ndarray) -> Finding:
    """Check that kinetic energy grows by powers (states, terms) [W] alone.

    v . (M a + bias) is the rate of v . M v / 2.
    """
    gains = (motion.v * motion.inertial).sum(axis=1) - powers.sum(axis=1)
    sizes = (np.abs(motion.v) * motion.summed).sum(axis=1) + np.abs(powers).sum(axis=1)
    return check_balance(about, gains, sizes)


def check_balance(about: Subject, gaps: np.ndarray, sizes: np.ndarray) -> Finding:
    """The Finding of a balance, from its residual and its terms' size at every state (states,)."""
    size, measured = float(np.sqrt((sizes**2).mean())), float(np.abs(gaps).max())
    return make_share_check(about, measured, TOLERANCE, size, "the terms' size", f": {BASIS}")


def compute_motion(given: StateValues, setting: Setting, scenario: Scenario) -> Motion:
    """The motion that a model's values give at the states of a setting, and what drives it."""
    (t, q, v), (mass, bias, force, a), arm = setting.states, given, setting.arm
    theta, rates = q[:, setting.layout.theta], v[:, setting.layout.theta]
    friction = np.array([joint.friction_N_m_s_per_rad for joint in arm.joints])
    return Motion(
        setting.layout,
        v,
        np.einsum("sij,sj->si", mass, a) + bias,
        np.einsum("sij,sj->si", np.abs(mass), np.abs(a)) + np.abs(bias),
        force,
        torques_along(drive_data(scenario, len(arm.joints)), t, theta, rates),
        weight_moments(arm, theta) - friction * rates,
    )


def external_powers(arm: Arm, motion: Motion) -> np.ndarray:
    """Power that weight and friction, then motors supply [W], (states, 2 joints).

    A motor with gears turns its sun, by the ratio times as fast as the link and by the meshes.
    """
    rates = motion.v[:, motion.layout.theta]
    turning = rates.copy()
    for number, joint in geared_joints(arm):
        radius, ratio = sun_radius_and_ratio(joint)
        turning[:, number] += motion.v @ sun_advance(motion.layout, number) / (radius * ratio)
    return np.hstack([motion.passive * rates, motion.torques * turning])


def _angular_momentum_residual(arm: Arm, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Residual of dH/dt = T_1 / n + (N F_pr1 + d_pr x_pr1') r_r + friction + weight, and its size.

    Both (states,). Turning the whole arm turns the first ring's teeth past its planets: x_pr1
    changes by -r_r, of every planet, and so does the sun's advance.
    """
    joint, shoulder = arm.joints[0], motion.layout.at("theta", 0)
    rate, size = motion.inertial[:, shoulder], motion.summed[:, shoulder]
    moments = [motion.torques[:, 0], motion.passive[:, 0]]
    if isinstance(joint, Planetary):
        radius, ratio = sun_radius_and_ratio(joint)
        ring, motor = radius * joint.ring_teeth / joint.sun_teeth, motion.torques[:, 0] / ratio
        slides = [
            place
            for place in displacement_places(motion.layout, 0)
            if motion.layout.coordinates[place].meaning != "x_sp"
        ]
        rate = rate - ring * motion.inertial[:, slides].sum(axis=1)
        size = size + ring * motion.summed[:, slides].sum(axis=1)
        on_teeth = (motor / radius - motion.force[:, slides].sum(axis=1)) * ring
        moments = [motor, on_teeth, motion.passive[:, 0]]
    return rate - np.sum(moments, axis=0), size + np.abs(moments).sum(axis=0)


def sun_advance(layout: Layout, joint: int) -> np.ndarray:
    """Row (n,) that gives x_sp + x_pr of a joint, counted from 0; the same for each planet."""
    x_sp, x_pr = (layout.displacement(mesh, joint, 0) for mesh in MESHES)
    return x_sp + x_pr


def displacement_places(layout: Layout, joint: int) -> list[int]:
    """Places of the coordinates that are displacements of the teeth of a joint, counted from 0."""
    return [
        place
        for place, coordinate in enumerate(layout.coordinates)
        if not coordinate.is_angle and coordinate.joint == joint + 1
    ]


def sun_radius_and_ratio(joint: Planetary) -> tuple[float, float]:
    """(base radius of the sun [m], speed ratio) from the joint's own numbers."""
    ratio = (joint.sun_teeth + joint.ring_teeth) / joint.sun_teeth
    return base_radius(joint, joint.sun_teeth), ratio


def check_constraints(about: Subject, gaps: np.ndarray) -> Finding:
    """Check that joints closed by constraint equations stay closed, at the model's own motion.

    gaps (count,): the largest gap, rate or acceleration over its size at each state, or how far it
    is from what it must be once the joints are opened on purpose.
    """
    basis = "rounding of places of a metre, rates and accelerations of their own size"
    return make_check(about, measured=float(gaps.max()), tolerance=GAP_TOLERANCE, basis=basis)
