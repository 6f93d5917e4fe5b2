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
from crosscheck.models.arm.layout import MESHES, Coordinate, Layout
from crosscheck.models.experiment.drive import DriveData, drive_data, joint_torque
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


class ForcedState(NamedTuple):
    """One state, what moves it and how it moves: M a + bias [n], force [n], torques [joints].

    summed [n]: the magnitudes whose sum ``inertial`` is, |M| |a| + |bias|; their rounding stays.
    passive [joints]: moments of weight and friction [N m].
    """

    layout: Layout
    v: np.ndarray
    inertial: np.ndarray
    summed: np.ndarray
    force: np.ndarray
    torques: np.ndarray
    passive: np.ndarray

    def power_residual(self, powers: list[float]) -> tuple[float, float]:
        """Gain of kinetic energy beyond these powers [W], and the size of the summed terms [W].

        v . (M a + bias) is the rate of v . M v / 2.
        """
        size = np.abs(self.v) @ self.summed + np.abs(powers).sum()
        return float(self.v @ self.inertial - np.sum(powers)), float(size)


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
    pairs = []
    for motion in compute_forced_states(given, setting, case.scenario):
        terms = external_powers(setting.arm, motion)
        for number, joint in geared_joints(setting.arm):
            radius, ratio = sun_radius_and_ratio(joint)
            motor = motion.torques[number] / ratio * sun_advance(motion.layout, number) / radius
            rows = [
                k for k, c in enumerate(motion.layout.coordinates) if is_displacement_of(c, number)
            ]
            terms += [*((motion.force - motor) * motion.v)[rows]]
        pairs.append(motion.power_residual(terms))
    return check_balance(about, pairs)


def check_angular_momentum(
    about: Subject, given: StateValues, setting: Setting, case: Case
) -> Finding:
    """Check that the whole arm's angular momentum changes by what the ground exerts."""
    forced_states = compute_forced_states(given, setting, case.scenario)
    return check_balance(about, [_angular_momentum_residual(setting.arm, m) for m in forced_states])


def check_balance(about: Subject, pairs: list[tuple[float, float]]) -> Finding:
    """The Finding of a balance, from its residual and its terms' size at every state."""
    gaps, sizes = np.array(pairs).T
    size, measured = float(np.sqrt((sizes**2).mean())), float(np.abs(gaps).max())
    return make_share_check(about, measured, TOLERANCE, size, "the terms' size", f": {BASIS}")


def compute_forced_states(
    given: StateValues, setting: Setting, scenario: Scenario
) -> Iterator[ForcedState]:
    """A ForcedState for each state: what moves it and how it moves."""
    drive = drive_data(scenario, len(setting.arm.joints))
    mass, a, bias = given.mass_matrix, given.acceleration, given.bias
    inertial = np.einsum("kij,kj->ki", mass, a) + bias
    summed = np.einsum("kij,kj->ki", np.abs(mass), np.abs(a)) + np.abs(bias)
    friction = np.array([joint.friction_N_m_s_per_rad for joint in setting.arm.joints])
    moving = zip(*setting.states, inertial, summed, given.generalized_force, strict=True)
    for t, q, v, moved, magnitude, force in moving:
        theta, theta_dot = q[setting.layout.theta], v[setting.layout.theta]
        torques = torques_at(drive, t, theta, theta_dot)
        passive = weight_moments(setting.arm, theta) - friction * theta_dot
        yield ForcedState(setting.layout, v, moved, magnitude, force, torques, passive)


def torques_at(drive: DriveData, t: float, theta: np.ndarray, theta_dot: np.ndarray) -> np.ndarray:
    """Output-side torques [N m], shape (joints,), by the scenario's law at time t [s]."""
    rows = zip(drive.gains, drive.table_torque, theta, theta_dot, strict=True)
    return np.array(
        [joint_torque(drive.code, g, drive.table_time, table, t, q, v) for g, table, q, v in rows]
    )


def external_powers(arm: Arm, motion: ForcedState) -> list[float]:
    """Power that motors, weight and friction supply [W], term by term."""
    dtheta = motion.v[motion.layout.theta]
    powers = [*(motion.passive * dtheta)]
    for number, (joint, torque) in enumerate(zip(arm.joints, motion.torques, strict=True)):
        turning = dtheta[number]
        if isinstance(joint, Planetary):
            radius, ratio = sun_radius_and_ratio(joint)
            slides = sun_advance(motion.layout, number) @ motion.v
            torque, turning = torque / ratio, slides / radius + ratio * turning
        powers.append(torque * turning)
    return powers


def _angular_momentum_residual(arm: Arm, motion: ForcedState) -> tuple[float, float]:
    """Residual of dH/dt = T_1 / n + (N F_pr1 + d_pr x_pr1') r_r + friction + weight, and its size.

    Turning the whole arm turns the first ring's teeth past its planets: x_pr1 changes by -r_r, of
    every planet, and so does the sun's advance.
    """
    joint, shoulder = arm.joints[0], motion.layout.at("theta", 0)
    outside, torque = motion.passive[0], motion.torques[0]
    if not isinstance(joint, Planetary):
        size = motion.summed[shoulder] + abs(torque) + abs(outside)
        return float(motion.inertial[shoulder] - torque - outside), float(size)
    radius, ratio = sun_radius_and_ratio(joint)
    ring, motor = radius * joint.ring_teeth / joint.sun_teeth, torque / ratio
    slides = [k for k, c in enumerate(motion.layout.coordinates) if is_displacement_of(c, 0)]
    slides = [k for k in slides if motion.layout.coordinates[k].meaning != "x_sp"]
    rate = motion.inertial[shoulder] - ring * motion.inertial[slides].sum()
    on_teeth = (motor / radius - motion.force[slides].sum()) * ring
    terms = np.array([motor, on_teeth, outside])
    size = motion.summed[shoulder] + ring * motion.summed[slides].sum() + np.abs(terms).sum()
    return float(rate - terms.sum()), float(size)


def sun_advance(layout: Layout, joint: int) -> np.ndarray:
    """Row (n,) that gives x_sp + x_pr of a joint, counted from 0; the same for each planet."""
    x_sp, x_pr = (layout.displacement(mesh, joint, 0) for mesh in MESHES)
    return x_sp + x_pr


def is_displacement_of(coordinate: Coordinate, joint: int) -> bool:
    """Whether a coordinate is a displacement of the teeth of a joint, counted from 0."""
    return not coordinate.is_angle and coordinate.joint == joint + 1


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
