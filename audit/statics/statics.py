"""Numbers that statements of Sections 2 to 4 rest on and that follow from the arm's data alone."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.paper.model import EnergiesModel, PrintedModel
from crosscheck.audit.errata import transcript
from crosscheck.audit.experiments.question import Question, Records
from crosscheck.audit.experiments.variant import Numbers
from crosscheck.audit.measures.stage import PaperStage, paper_stage, thickness_share, tip_shift
from crosscheck.audit.statics.base_and_gravity import compute_base_errors, compute_neglected_torques
from crosscheck.audit.statics.teeth import (
    compare_stiffness_wave,
    compute_clearance,
    compute_gearing,
)
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.loading import load_arm, load_scenario

SCENARIO = "constant-torque"  # in which equations are compared
POSES, SEED = 20, 20150401
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
        "initial_values": float(len(transcript.INITIAL_VALUES)),
        "tooth_thickness_share": thickness_share(stage),
        "error_over_backlash": stage.tooth_error_m / stage.backlash_m,
        **{f"bent_{angle}_mm": 1e3 * tip_shift(arm, float(angle)) for angle in BENDS},
    }


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
