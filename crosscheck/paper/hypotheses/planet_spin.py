"""Hypothesis H4: what it costs that Eq. 18 leaves link 1's rotation out of the elbow's planets."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from crosscheck.checks.trajectories import largest_difference, tip_position
from crosscheck.paper.errata.finder import energy_errata
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import percent, shown
from crosscheck.report.chapter import Chapter, rendered
from crosscheck.report.fragments import heading, paragraph, table
from crosscheck.studies.study import Study
from models.loading import load_arm, load_scenario

READINGS = ("paper-labelled", "paper-swapped")
DURATIONS_S = {"constant-torque": 0.5, "pd": 3.0}
WHERE = "Eq. 18, planets 2"
CONSIDERABLE_M = 0.03  # the tip error that Section 3.1 calls considerable
ID, TITLE = "planet_spin", "The elbow planets' spin (H4)"
STRIDE = 50  # records of angles and forces, 0.5 ms


@dataclass(frozen=True)
class Difference:
    """What the spin changes: inertia missing in M_33 [kg m^2], its share, largest differences.

    theta_rad, mesh_force_N of any joint; tip_m: distance.
    """

    arm: str
    scenario: str
    duration_s: float
    share_of_M_33_kg_m2: float | None
    relative: float | None
    theta_rad: float
    tip_m: float
    mesh_force_N: float

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        return {"id": f"H4/{self.arm}/{self.scenario}", **asdict(self)}


@dataclass(frozen=True)
class SpinVerdict:
    """H4, by the largest difference."""

    largest: Difference

    @property
    def verdict(self) -> str:
        """In words."""
        return "considerable" if matters(self.largest.tip_m) else "not considerable"

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        return {
            "id": "H4",
            "verdict": self.verdict,
            "largest_tip_m": self.largest.tip_m,
            "where": f"{self.largest.arm}, {self.largest.scenario}",
        }


@dataclass(frozen=True)
class SpinCost:
    """Eqs. 16-19 as printed, and with the elbow planets' true spin, through one scenario."""

    arm: str
    scenario: str
    duration_s: float

    @property
    def inputs(self) -> str:
        records = (load_arm(self.arm), load_scenario(self.scenario))
        return "\n".join([repr(self), *(record.model_dump_json() for record in records)])

    @property
    def cost(self) -> float:
        return self.duration_s

    def answer(self) -> Difference:
        arm = load_arm(self.arm)
        (slip,) = (erratum for erratum in energy_errata(arm) if erratum.where == WHERE)
        assert slip.trial is not None  # an energy can always be put right
        update = {"duration_s": self.duration_s, "record_every": STRIDE}
        scenario = load_scenario(self.scenario).model_copy(update=update)
        sides = (slip.trial.as_printed, slip.trial.put_right)
        printed, right = (side(scenario).simulate() for side in sides)
        apart = tip_position(printed, arm).values - tip_position(right, arm).values
        return Difference(
            arm=self.arm,
            scenario=self.scenario,
            duration_s=scenario.duration_s,
            share_of_M_33_kg_m2=slip.size,
            relative=slip.relative,
            theta_rad=largest_difference(printed, right, "theta"),
            tip_m=float(np.linalg.norm(apart, axis=1).max()),
            mesh_force_N=largest_difference(printed, right, "F_sp"),
        )


def matters(tip_error_m: float) -> bool:
    """Whether the tip moves by what the paper calls considerable."""
    return tip_error_m >= CONSIDERABLE_M


def chapter(study: Study, scale: Scale) -> Chapter:
    """Both readings and scenarios."""
    wanted = [
        SpinCost(arm, scenario, scale.seconds(duration_s))
        for arm in READINGS
        for scenario, duration_s in DURATIONS_S.items()
    ]
    found = study.answers(wanted, "H4, planet spin")
    verdict = SpinVerdict(max(found, key=lambda difference: difference.tip_m))
    text = [
        heading("H4: the elbow planets' share of link 1's rotation"),
        paragraph(_question(found[0])),
        table(_HEAD, [_row(difference) for difference in found]),
        paragraph(_answer(verdict)),
    ]
    outcome = f"{verdict.verdict}, at most {1000 * verdict.largest.tip_m:.2g} mm at the tip."
    return Chapter(ID, TITLE, "\n".join(text), rendered((verdict, *found)), outcome)


_HEAD = (
    "reading",
    "scenario",
    "missing in M_33 [kg m²]",
    "Δθ [rad]",
    "tip [mm]",
    "mesh force per planet [N]",
)


def _row(found: Difference) -> tuple[str, ...]:
    return (
        found.arm.removeprefix("paper-"),
        f"{found.scenario}, {found.duration_s:g} s",
        f"{shown(found.share_of_M_33_kg_m2)} ({percent(found.relative, '.2g')})",
        f"{found.theta_rad:.3g}",
        f"{1000 * found.tip_m:.3g}",
        f"{found.mesh_force_N:.3g}",
    )


def _question(found: Difference) -> str:
    return (
        "Question: a planet of the elbow turns with link 1, against which its own angle is counted,"
        " but Eq. 18 gives it the spin of its own joint alone. What does that cost? Experiment:"
        " Eqs. 16 to 19 as printed against the same with this one spin put right, everything else"
        " alike (default damping, phase angle); the energy lacks"
        f" {shown(found.share_of_M_33_kg_m2, '.2g')} kg m² in M_33 and the products of the two"
        " joints' rates. Largest difference over the run:"
    )


def _answer(verdict: SpinVerdict) -> str:
    largest = verdict.largest
    return (
        f"At most {1000 * largest.tip_m:.2g} mm at the tip ({largest.scenario}, reading"
        f" {largest.arm.removeprefix('paper-')}) against the {1000 * CONSIDERABLE_M:g} mm that"
        f" Section 3.1 calls considerable. Verdict: the cost is {verdict.verdict}."
    )
