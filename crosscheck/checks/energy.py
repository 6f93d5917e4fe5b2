"""Energy with the springs' own: a function of state where teeth are a potential and undamped."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.checks import invariants
from crosscheck.checks.answers import States
from crosscheck.checks.first_principles import composite
from crosscheck.checks.first_principles.mesh_energy import (
    POINTS,
    MeshSpring,
    energy_slope,
    highest_harmonic,
    mesh_springs,
    spring_energy,
)
from crosscheck.checks.sampled import (
    FIRST_PRINCIPLES,
    ExperimentPlan,
    Subjects,
    find_experiments,
    find_usual,
)
from crosscheck.checks.scales import find_parts, geared_joints, meshes, motor_lever
from crosscheck.findings import (
    ComparisonKey,
    Finding,
    Subject,
    make_failed_check,
    make_measurement,
    make_share_check,
)
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import MESHES, Layout
from crosscheck.models.experiment.scenario import ConstantDrive, Switches, expand_to_joints
from crosscheck.models.loading import Case
from crosscheck.planning.comparison import Comparison, ModelTask, make_comparison

if TYPE_CHECKING:
    import xarray as xr


# Along a straight way through the state no wave of a stiffness turns further [rad], which leaves
# 1e-14 of the fourth order, and at most so long [s]; 1e-16 of some joules stay far below 1e-10 of
# their rate.
ALONG_RAD, ALONG_S = 3e-4, 1e-6
# Of the work turned over. At these steps RK4 leaves 1.4e-10 on the paper's arm, a rule of second
# order 6e-11, the adaptive reference 2e-11 where teeth meet.
CLOSES = 1e-9
# Of the work done: two orders above what the reference integrator asks of each step.
WORK_TOLERANCE = 1e-9
# Leaves 2e-11 of the work turned over where teeth meet, 1e-10 leaves 2e-8. One step in some
# thousand may leap over an edge of play that its error estimate does not see, which costs 1e-8.
RTOL, FINER_RTOL = 1e-12, 3e-13
OVER_RUN = "largest difference of energy gained and work done over the run"
CONSERVED = "largest change of kinetic, spring and weight's energy less the motors' work"


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons of the energy's rate where springs are a potential, and of what runs make of it.

    A run without losses keeps it, unless a fixed step crosses the edge of the backlash: so these
    have none, and the adaptive reference, which sees the edge, has. The energy that the paper's law
    makes out of nothing is measured beside.
    """
    for arm in subjects.arms:
        if arm.group == "conservative":
            yield invariants.plan_balance(arm, "energy-rate", "W", _check_energy_rate)
    for experiment in find_usual(subjects):
        run = experiment.run(experiment.models.same[0], "reference")
        yield _plan_runs(experiment, OVER_RUN, check_energy_over_run, run)
    for experiment in find_experiments(subjects, "energy"):
        yield from _plan_conservation(experiment)


def _plan_conservation(experiment: ExperimentPlan) -> Iterator[Comparison]:
    """Energy balances of an experiment without losses, by its name those of some of the models."""
    same, other, constrained, *_ = experiment.models
    judge = partial(check_energy_conservation, case=experiment.case)
    reference = experiment.run(same[0], "reference", RTOL)
    if experiment.name == "energy-paper":
        judge = partial(measure_energy_drift, case=experiment.case)
        yield _plan_runs(experiment, CONSERVED, judge, reference)
    elif experiment.name == "energy-impacts":
        again = experiment.run(same[0], "reference-finer", FINER_RTOL)
        yield _plan_runs(experiment, CONSERVED, judge, reference, again)
    else:
        for model in same if experiment.name == "energy" else (*other, *constrained):
            yield _plan_runs(experiment, CONSERVED, judge, experiment.run(model))


def _plan_runs(
    experiment: ExperimentPlan, metric: str, judge: Callable[..., Finding], *runs: ModelTask
) -> Comparison:
    """The energy balance of a run, or the best of several: what a law makes it makes in all."""
    key = ComparisonKey("invariants", experiment.name, "energy", runs[0].model)

    def judge_runs(about: Subject, *runs: xr.Dataset) -> Finding:
        return min((judge(about, each) for each in runs), key=lambda found: found.relative or 0.0)

    return make_comparison(Subject(key, "J", metric, FIRST_PRINCIPLES), runs, judge_runs)


def _check_energy_rate(about: Subject, motion: invariants.DrivenMotion) -> Finding:
    """Check that kinetic and spring energy gain what motors, weight and friction put in."""
    arm, _, laws = motion.setting.case
    rates = _spring_rates(arm, laws, motion.setting.layout, motion.setting.states)
    powers = np.column_stack([invariants.external_powers(motion), -rates])
    return invariants.check_powers(about, motion, powers)


def _spring_rates(arm: Arm, chosen: Switches, layout: Layout, states: States) -> np.ndarray:
    """dV/dt of the springs [W], (states,): fourth-order central differences on each one's flank."""
    rates = np.abs(states.v[:, layout.theta])
    fastest = np.max(  # wave of any mesh [rad/s]
        [
            joint.ring_teeth * rates[:, number] * highest_harmonic(mesh.stiffness)
            for number, joint in geared_joints(arm)
            for mesh in meshes(joint)
        ],
        axis=0,
    )
    with np.errstate(divide="ignore"):
        step = np.minimum(ALONG_S, ALONG_RAD / fastest)  # half a difference's length
    ways = states.q + POINTS[:, None, None] * step[:, None] * states.v
    total = np.zeros(len(states.q))
    for spring in springs_at(arm, chosen, layout, ways.reshape(-1, ways.shape[-1])):
        stiffness, gap = (x.reshape(ways.shape[:2]) for x in (spring.stiffness, spring.gap))
        total += energy_slope(MeshSpring(spring.backlash, stiffness, gap), step)
    return total


def springs_at(arm: Arm, chosen: Switches, layout: Layout, q: np.ndarray) -> Iterator[MeshSpring]:
    """The springs of all meshes at states q (times, n)."""
    planets = max(joint.planet_count for joint in arm.joints)
    x = np.zeros((2, len(q), len(arm.joints), planets))
    for joint in layout.mesh_joints:
        for side, mesh in enumerate(MESHES):
            for planet in range(arm.joints[joint].planet_count):
                x[side, :, joint, planet] = q @ layout.displacement(mesh, joint, planet)
    return mesh_springs(arm, chosen, q[:, layout.theta], x[0], x[1])


def check_energy_conservation(about: Subject, run: xr.Dataset, case: Case) -> Finding:
    """Check that the energy of a run without losses, under constant torques, stays what it was."""
    strayed, turned = _balance(run, case)
    return make_share_check(about, strayed, CLOSES, turned, "the work turned over")


def measure_energy_drift(about: Subject, run: xr.Dataset, case: Case) -> Finding:
    """Measure the energy's change with the springs' work on angles left out, as in the paper."""
    strayed, turned = _balance(run, case)
    basis = f"of the work turned over, {turned:.3g} J"
    share = strayed / turned if turned else None
    return make_measurement(about, measured=strayed, basis=basis, relative=share)


def _balance(run: xr.Dataset, case: Case) -> tuple[float, float]:
    """Largest change of the energy since its start, and the work turned over by its parts [J]."""
    arm, theta = case.arm, run["theta"].values
    x_sp, x_pr = (run[mesh].values for mesh in MESHES)
    held = [spring_energy(spring) for spring in mesh_springs(arm, case.switches, theta, x_sp, x_pr)]
    work = _motors_work(arm, case, theta, (x_sp + x_pr)[:, :, 0])
    kinetic, weight = run["kinetic_energy"].values, weight_energy(arm, theta)
    parts = np.array([kinetic, weight, -work, *held])
    total = parts.sum(axis=0)
    turned = np.abs(np.diff(parts, axis=1)).sum()
    return float(np.abs(total - total[0]).max()), float(turned)


def weight_energy(arm: Arm, theta: np.ndarray) -> np.ndarray:
    """Potential energy of all masses in gravity [J], shape (times,), theta (times, joints)."""
    (content, parts), pull = find_parts(arm), complex(*arm.gravity_m_per_s2)
    places = composite.find_centres(parts, composite.arm_pose(content, theta))
    moments = places @ np.array([part.mass for part in parts])
    return np.asarray(-(np.conj(moments) * pull).real)


def _motors_work(arm: Arm, case: Case, theta: np.ndarray, advance: np.ndarray) -> np.ndarray:
    """Work of constant torques [J], (times,): T / n on a sun by its angle, T on a link by its own.

    advance (times, joints): x_sp + x_pr [m].
    """
    drive = case.scenario.drive
    assert isinstance(drive, ConstantDrive)  # as these experiments have
    work = np.zeros(len(theta))
    for number, torque in enumerate(expand_to_joints(drive.torque_N_m, len(arm.joints))):
        joint, angle = arm.joints[number], theta[:, number]
        if isinstance(joint, Planetary):
            angle = advance[:, number] / motor_lever(joint) + angle
        work += torque * (angle - angle[0])
    return work


def check_energy_over_run(about: Subject, run: xr.Dataset) -> Finding:
    """Check kinetic energy gained against work done, over a run that integrated the work along."""
    absent = [name for name in ("work", "work_turned_over") if name not in run]
    if absent:
        return make_failed_check(about, f"the run has no {absent[0]}")
    gained = run["kinetic_energy"].values - run["kinetic_energy"].values[0]
    work = run["work"].values
    size = float(run["work_turned_over"].values[-1])
    measured = float(np.abs(gained - work).max())
    return make_share_check(about, measured, WORK_TOLERANCE, size, "the work turned over")
