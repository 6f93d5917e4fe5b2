"""What it costs that Eq. 18 leaves link 1's rotation out of the elbow's planets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crosscheck.audit.errata.finder import find_energy_errata
from crosscheck.audit.experiments.question import Question, Records
from crosscheck.checks.trajectories import largest_difference, tip_position
from crosscheck.models.loading import load_arm, load_scenario

WHERE = "Eq. 18, planets 2"
CONSIDERABLE_M = 0.03  # the tip error that Section 3.1 calls considerable
STRIDE = 50  # records of angles and forces, 0.5 ms


@dataclass(frozen=True)
class Difference:
    """Changes by the spin: inertia missing in M_33 [kg m^2], its share, the largest differences.

    theta_rad, mesh_force_N of any joint; tip_m: distance.
    """

    arm: str
    scenario: str
    duration_s: float
    missing_kg_m2: float | None
    relative: float | None
    theta_rad: float
    tip_m: float
    mesh_force_N: float


@dataclass(frozen=True)
class SpinCost(Question[Difference]):
    """A question: one scenario by Eqs. 16-19 as printed and with the elbow planets' true spin."""

    cost = 3.0

    arm: str
    scenario: str
    duration_s: float

    def records(self) -> Records:
        return load_arm(self.arm), load_scenario(self.scenario)

    def answer(self) -> Difference:
        arm = load_arm(self.arm)
        (spin,) = (erratum for erratum in find_energy_errata(arm) if erratum.where == WHERE)
        assert spin.trial is not None  # an energy can always be put right
        update = {"duration_s": self.duration_s, "record_every": STRIDE}
        scenario = load_scenario(self.scenario).model_copy(update=update)
        sides = (spin.trial.as_printed, spin.trial.put_right)
        printed, right = (side(scenario).simulate() for side in sides)
        tip_difference = tip_position(printed, arm).values - tip_position(right, arm).values
        return Difference(
            arm=self.arm,
            scenario=self.scenario,
            duration_s=scenario.duration_s,
            missing_kg_m2=spin.size,
            relative=spin.relative,
            theta_rad=largest_difference(printed, right, "theta"),
            tip_m=float(np.linalg.norm(tip_difference, axis=1).max()),
            mesh_force_N=largest_difference(printed, right, "F_sp"),
        )


def is_considerable(tip_error_m: float) -> bool:
    """Whether the tip moves by what the paper calls considerable."""
    return tip_error_m >= CONSIDERABLE_M
