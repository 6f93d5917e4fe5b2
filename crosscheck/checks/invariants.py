"""Invariants of any model of an arm: balances of power and momentum, joints that stay closed.

All use a model's own M, bias, force and acceleration on one side and first principles on the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.answers import EQUATIONS, BadAnswer, Setting, acceleration, require_numbers
from crosscheck.checks.sampled import SampledArm, Subjects
from crosscheck.checks.scales import (
    arm_reach,
    base_radius,
    geared_joints,
    motor_forces,
    motor_lever,
    sun_advance,
    weight_moments,
)
from crosscheck.findings import (
    ComparisonKey,
    Finding,
    Subject,
    make_check,
    make_failed_check,
    make_share_check,
)
from crosscheck.models.arm.arm import Planetary
from crosscheck.models.experiment.drive import drive_data, torques_along
from crosscheck.models.interface import Model
from crosscheck.planning.comparison import Comparison, make_comparison

# Powers of 1e4 N x 0.1 m/s whose forces carry the rounding of displacements (see states).
TOLERANCE = 1e-10
BASIS = "rounding of the forces, as for accelerations"
GAP_TOLERANCE = 1e-12
OPENED = 1e-3  # gaps, rates and accelerations by which joints are opened, of their sizes


class DrivenMotion(NamedTuple):
    """What moves an arm and how it moves, at all states: M a + bias, force and rates (states, n).

    summed: the magnitudes whose sum ``inertial`` is, |M| |a| + |bias|; their rounding stays.
    torques and passive (states, joints): motors, and moments of weight and friction [N m].
    """

    setting: Setting
    v: np.ndarray
    inertial: np.ndarray
    summed: np.ndarray
    force: np.ndarray
    torques: np.ndarray
    passive: np.ndarray


Balance = Callable[[Subject, DrivenMotion], Finding]


def abilities(model: Model, setting: Setting) -> np.ndarray:
    """The names of the methods that a model says it has."""
    return np.array(sorted(model.abilities))


def constraint_residual(model: Model, setting: Setting) -> np.ndarray:
    """Largest gap, rate or acceleration of a model's joints over its size, (states,).

    How far they are from what they must be with the joints opened on purpose counts too.
    """
    states = zip(*setting.states[1:], acceleration(model, setting), strict=True)
    return np.array([_widest_gap(model, *state) for state in states])


def _widest_gap(model: Model, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> float:
    closed = _gaps(model.constraint_residual(q.copy(), v.copy(), a.copy()))
    reach = arm_reach(model.arm)
    angular = model.layout.angular
    sizes = [max(1.0, reach * float(np.abs(vector[angular]).max())) for vector in (v * 0, v, a)]
    size = np.array(sizes)[:, None]
    opened = OPENED * size * np.cos(np.arange(closed.size)).reshape(closed.shape)
    opened_residuals = _gaps(model.constraint_residual(q.copy(), v.copy(), a.copy(), opened.copy()))
    if opened_residuals.shape != opened.shape:
        raise BadAnswer("constraint_residual has other joints once they are opened")
    return float(max(np.abs(closed / size).max(), np.abs((opened_residuals - opened) / size).max()))


def _gaps(residuals: object) -> np.ndarray:
    """Gaps, rates and accelerations of joints, shape (3, gaps). Raises BadAnswer."""
    if not isinstance(residuals, tuple) or len(residuals) != 3:
        raise BadAnswer("constraint_residual is not gaps, rates and accelerations")
    gaps, *others = (require_numbers(r, "constraint_residual", None) for r in residuals)
    if gaps.size == 0 or any(other.shape != gaps.shape for other in others):
        raise BadAnswer("constraint_residual is empty, or its parts are of unequal shapes")
    return np.array([gaps.ravel(), *(other.ravel() for other in others)])


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons of each model with itself: its balances, its joints, and its abilities.

    A model must say of itself all that the registry says of it, for users ask the model.
    """
    for arm in subjects.arms:
        if arm.owes_laws:
            key = ComparisonKey("invariants", arm.where, "abilities", arm.model)
            about = Subject(key, "1", "abilities missing", "declared capabilities")
            judge = partial(_check_abilities, promised=arm.promises)
            yield make_comparison(about, [arm.ask_once(abilities)], judge)
        if arm.group in ("geared", "free", "form"):
            yield from plan_balances(arm)
        if arm.group == "geared" and "constraint_residual" in arm.promises:
            count = arm.setting.count
            metric = f"largest gap, rate, acceleration or error of one, {count} random states"
            questions, against = [constraint_residual], "closure of its joints"
            yield arm.plan_law("constraints", questions, check_constraints, metric, against)


def plan_balances(arm: SampledArm) -> Iterator[Comparison]:
    """Comparisons of power and angular momentum, from all that the model says of a state."""
    yield plan_balance(arm, "power", "W", check_power_balance)
    yield plan_balance(arm, "angular-momentum-rate", "N m", check_angular_momentum)


def plan_balance(arm: SampledArm, name: str, unit: str, law: Balance) -> Comparison:
    """The comparison of one balance of a model."""

    def judge(about: Subject, *given: Any) -> Finding:
        return law(about, compute_motion(*given))

    return arm.plan_law(name, EQUATIONS, judge, arm.over("largest residual"), unit=unit)


def _check_abilities(about: Subject, claimed: Any, promised: frozenset[str]) -> Finding:
    lacking = sorted(promised - set(claimed.tolist()))
    if lacking:
        return make_failed_check(about, f"the model does not claim to have {', '.join(lacking)}")
    return make_check(about, measured=0.0, tolerance=0.0, basis="every promised ability is there")


def check_power_balance(about: Subject, motion: DrivenMotion) -> Finding:
    """Check d(kinetic)/dt = sum of T theta_s' / n + powers of meshes, dampers, weight, friction.

    A motor turns its sun n times as fast as the link, and by the mesh displacements.
    """
    arm, layout = motion.setting.arm, motion.setting.layout
    on_teeth = motion.force - motor_forces(arm, layout, motion.torques)
    powers = (on_teeth * motion.v)[:, ~motion.setting.layout.angular]
    return check_powers(about, motion, np.hstack([external_powers(motion), powers]))


def check_powers(about: Subject, motion: DrivenMotion, powers: np.ndarray) -> Finding:
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


def compute_motion(
    mass: np.ndarray, bias: np.ndarray, force: np.ndarray, a: np.ndarray, setting: Setting
) -> DrivenMotion:
    """The motion by a model's M (states, n, n), bias, force and acceleration (states, n)."""
    (t, q, v), arm, layout = setting.states, setting.arm, setting.layout
    theta, rates = q[:, layout.theta], v[:, layout.theta]
    drive = drive_data(setting.case.scenario, len(arm.joints))
    friction = np.array([joint.friction_N_m_s_per_rad for joint in arm.joints])
    return DrivenMotion(
        setting,
        v,
        inertial=np.einsum("sij,sj->si", mass, a) + bias,
        summed=np.einsum("sij,sj->si", np.abs(mass), np.abs(a)) + np.abs(bias),
        force=force,
        torques=torques_along(drive, t, theta, rates),
        passive=weight_moments(arm, theta) - friction * rates,
    )


def external_powers(motion: DrivenMotion) -> np.ndarray:
    """Power that weight and friction, then motors supply [W], (states, 2 joints).

    A motor with gears turns its sun, by the ratio times as fast as the link and by the meshes.
    """
    rates = motion.v[:, motion.setting.layout.theta]
    turning = rates.copy()
    for number, joint in geared_joints(motion.setting.arm):
        advance = sun_advance(motion.setting.layout, number)
        turning[:, number] += motion.v @ advance / motor_lever(joint)
    return np.hstack([motion.passive * rates, motion.torques * turning])


def check_angular_momentum(about: Subject, motion: DrivenMotion) -> Finding:
    """Check that the whole arm's angular momentum changes by what the ground exerts.

    dH/dt = T_1 / n + (N F_pr1 + d_pr x_pr1') r_r + friction + weight. Turning the whole arm turns
    the first ring's teeth past its planets: x_pr1 changes by -r_r, of every planet, and so does the
    sun's advance.
    """
    joint, layout = motion.setting.arm.joints[0], motion.setting.layout
    shoulder, names = layout.at("theta", 0), ("x_s", "x_pr")
    rate, size = motion.inertial[:, shoulder], motion.summed[:, shoulder]
    moments = [motion.torques[:, 0], motion.passive[:, 0]]
    if isinstance(joint, Planetary):
        radius, ring = (base_radius(joint, n) for n in (joint.sun_teeth, joint.ring_teeth))
        pressed = motion.torques[:, 0] / motor_lever(joint)
        motor = pressed * radius
        first = [c.joint == 1 and c.meaning in names for c in layout.coordinates]
        slides = np.flatnonzero(first)
        rate = rate - ring * motion.inertial[:, slides].sum(axis=1)
        size = size + ring * motion.summed[:, slides].sum(axis=1)
        on_teeth = (pressed - motion.force[:, slides].sum(axis=1)) * ring
        moments = [motor, on_teeth, motion.passive[:, 0]]
    size = size + np.abs(moments).sum(axis=0)
    return check_balance(about, rate - np.sum(moments, axis=0), size)


def check_constraints(about: Subject, gaps: np.ndarray, setting: object) -> Finding:
    """Check that joints closed by constraint equations stay closed, at the model's own motion.

    gaps (count,): the largest gap, rate or acceleration over its size at each state, or how far it
    is from what it must be once the joints are opened on purpose.
    """
    basis = "rounding of places of a metre, rates and accelerations of their own size"
    return make_check(about, measured=float(gaps.max()), tolerance=GAP_TOLERANCE, basis=basis)
