"""Numbers that statements rest on and that follow from the arm's data alone."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.paper.model import EnergiesModel, PrintedModel
from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.audit.experiments.study import Question, Records
from crosscheck.audit.experiments.variant import Numbers
from crosscheck.audit.measures.stage import PaperStage, paper_stage
from crosscheck.audit.statics.teeth import (
    compare_stiffness_wave,
    compute_clearance,
    compute_gearing,
    virtual_work,
)
from crosscheck.models.arm.arm import Arm, FreeArm, FreeBase, joint_mass
from crosscheck.models.experiment.scenario import (
    ConstantDrive,
    Scenario,
    expand_to_joints,
    switches,
)
from crosscheck.models.loading import Case, load_arm, load_case, load_scenario
from crosscheck.models.robot.planar import build_level_robots, build_planar_robot
from crosscheck.models.robot.robot import Level, Robot

EVERY = "scenario.record_every=1000"  # 10 ms
LEVEL: Level = "coupled"
SIDE_M = 2.0  # side of the cube that is the base
BASE_MASSES = ("5", "50", "500", "5000")  # over the arm's mass
CONSTANT = "constant-torque"
# The Earth's gravity parameter [m^3/s^2], and a low orbit's radius [m], 400 km up.
EARTH, ORBIT_M = 3.986e14, 6.771e6


def compute_base_errors(arm: str) -> Numbers:
    """Largest distance [mm] of the tip from where a fixed base would have it, by the base's mass.

    In the inertial frame, over the PD motion and over the constant torque's; the base is a
    homogeneous cube that shifts and turns.
    """
    cases = [load_case(arm, scenario, None, [EVERY]) for scenario in ("pd", CONSTANT)]
    errors = np.max([_tip_errors_m(case) for case in cases], axis=0)
    pairs = zip(BASE_MASSES, errors, strict=True)
    return {f"base_tip_{text}_mm": 1e3 * float(error) for text, error in pairs}


def _tip_errors_m(case: Case) -> list[float]:
    """The largest error of the tip [m] for every mass of the base."""
    fixed, _ = build_level_robots(case.arm)[LEVEL]
    path, carried = tip_path(fixed, case.scenario), arm_mass(case.arm)
    bases = [FreeBase(mass_kg=carried * float(ratio), side_m=SIDE_M) for ratio in BASE_MASSES]
    flights = (tip_path(free_robot(case.arm, base), case.scenario) for base in bases)
    return [float(np.linalg.norm(flight - path, axis=1).max()) for flight in flights]


def free_robot(arm: Arm, base: FreeBase) -> Robot:
    """The arm as a robot on a base that floats."""
    content = arm.model_dump(exclude_none=True)
    return build_planar_robot(FreeArm.model_validate({**content, "base": base.model_dump()}))


def arm_mass(arm: Arm) -> float:
    """Mass [kg] of all that the base carries: links, payload and the joints' gears with rings."""
    massive = free_robot(arm, FreeBase(mass_kg=1.0, side_m=SIDE_M))
    return float(sum(body.mass for body in massive.bodies)) - 1.0


def tip_path(robot: Robot, scenario: Scenario) -> np.ndarray:
    """The tip in the inertial frame (times, 2) [m] along a scenario, the base begun at rest."""
    start = scenario.start.model_copy(
        update={
            name: (0.0,) * len(robot.passive)
            + expand_to_joints(getattr(scenario.start, name), len(robot.motors))
            for name in ("theta_rad", "theta_dot_rad_per_s")
        }
    )
    model = AnalyticRobot(robot, LEVEL)
    q, _ = model.integrate(scenario.model_copy(update={"start": start}))
    return model.tip(q)[:, :2]


def compute_neglected_torques(arm: Arm, stage: PaperStage) -> Numbers:
    """Torques that Section 2.4's energies leave out, over the 100 N m of Section 3.1 [1]."""
    drive = load_scenario(CONSTANT).drive
    assert isinstance(drive, ConstantDrive)
    torque = float(np.max(drive.torque_N_m))
    return {
        "gravity_share": gravity_gradient(arm) / torque,
        "virtual_work_share": virtual_work(stage, torque) / torque,
    }


def gravity_gradient(arm: Arm) -> float:
    """Largest torque [N m] on the stretched arm in a low orbit about its shoulder: 3/2 w^2 I.

    I of its masses at their centres.
    """
    inner, outer = arm.links
    elbow, tip = inner.length_m, inner.length_m + outer.length_m
    places = [inner.com_m, elbow + outer.com_m, elbow, tip]
    masses = [*(link.mass for link in arm.links), joint_mass(arm.joints[1]), arm.payload_mass_kg]
    inertia = float(np.dot(masses, np.square(places)))
    return 1.5 * EARTH / ORBIT_M**3 * inertia


SCENARIO = "constant-torque"  # in which equations are compared
POSES, SEED = 20, 20150401
INITIAL_VALUES = ("b", "b", "0", "b", "b", "0", "0", "0", "0", "0", "0")  # Section 3
DEVIATIONS_RAD = (0.02, 0.01)  # Section 3.1: what both joints deviate by
EXTREME_M = 6e-3  # Section 4.1's largest clearance
BENDS = ("0", "45", "90", "135")  # elbow angle [deg] at which joint errors are taken to the tip


@dataclass(frozen=True)
class Statics(Question[Numbers]):
    """A question: the ``compute_statics`` of a built-in arm, and the flights of its free base."""

    cost = 5.0

    arm: str

    def records(self) -> Records:
        return load_arm(self.arm), load_scenario(SCENARIO), load_scenario("pd")

    def answer(self) -> Numbers:
        return {**compute_statics(load_arm(self.arm)), **compute_base_errors(self.arm)}


def compute_statics(arm: Arm) -> Numbers:
    """The numbers of an arm that follow from its data without a run."""
    stage = paper_stage(arm)
    return {
        **compute_gearing(stage),
        **compute_clearance(stage),
        **compare_stiffness_wave(stage),
        **compute_neglected_torques(arm, stage),
        **compare_equations(arm),
        **compute_data_numbers(arm, stage),
    }


def compute_data_numbers(arm: Arm, stage: PaperStage) -> Numbers:
    """Numbers on sizes that Table I and the text give, and what follows from them at once."""
    joint = stage.joint
    sun_pitch_m = joint.module_m * joint.sun_teeth / 2
    gyration_m = stage.geometry.r_s * math.sqrt(stage.sun_equivalent_mass_kg / joint.sun_mass_kg)
    return {
        "gyration_over_pitch": gyration_m / sun_pitch_m,
        "initial_values": float(len(INITIAL_VALUES)),
        "tooth_thickness_share": EXTREME_M / (math.pi * joint.module_m / 2),  # half a pitch
        "error_over_backlash": stage.tooth_error_m / stage.backlash_m,
        **{f"bent_{angle}_mm": 1e3 * tip_shift(arm, float(angle)) for angle in BENDS},
    }


def tip_shift(arm: Arm, bend_deg: float) -> float:
    """How far [m] Section 3.1's deviations move the tip, with the elbow bent so far."""
    inner, outer = (link.length_m for link in arm.links)
    forearm = outer * np.exp(1j * math.radians(bend_deg))
    first, second = DEVIATIONS_RAD
    return float(abs(first * (inner + forearm) + second * forearm))


def compare_equations(arm: Arm) -> Numbers:
    """Numbers of Eqs. 16-22 at random states: printed against energies against true velocities."""
    scenario = load_scenario(SCENARIO)
    chosen = switches(phase="omega_t")
    printed, energies, physical = (
        model(arm, scenario, chosen) for model in (PrintedModel, EnergiesModel, PhysicalModel)
    )
    generator = np.random.default_rng(SEED)
    scale = np.tile([1e-4, 1e-4, 1.0], 2)
    states = [(scale * q, scale * v) for q, v in generator.normal(size=(POSES, 2, 6))]
    of_printed, of_energies, of_physical = (
        [model.mass_matrix(q) for q, _ in states] for model in (printed, energies, physical)
    )
    return {
        "least_eigenvalue": float(min(np.linalg.eigvalsh(mass).min() for mass in of_printed)),
        "asymmetry": float(max(np.abs(mass - mass.T).max() for mass in of_printed)),
        "mass_slip": _largest_gap(of_printed, of_energies),
        "energy_gap": _largest_gap(of_energies, of_physical),
        "bias_slip": _largest_gap(
            [printed.bias(q, v) for q, v in states], [energies.bias(q, v) for q, v in states]
        ),
        "force_slip": _largest_gap(
            [printed.generalized_force(0.1, q, v) for q, v in states],
            [energies.generalized_force(0.1, q, v) for q, v in states],
        ),
    }


def _largest_gap(first: list[np.ndarray], second: list[np.ndarray]) -> float:
    """The largest difference of two lists of arrays, over the largest entry of the second."""
    return float(np.abs(np.subtract(first, second)).max() / np.abs(second).max())
