"""Hypothesis H4: what it costs that Eq. 18 leaves link 1's rotation out of the elbow's planets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from crosscheck.checks.trajectories import largest_difference, tip_position
from crosscheck.paper.errata.finder import energy_errata
from crosscheck.paper.scale import Scale
from crosscheck.report.chapter import Chapter
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

    def answer(self) -> dict[str, Any]:
        arm = load_arm(self.arm)
        (slip,) = (erratum for erratum in energy_errata(arm) if erratum.where == WHERE)
        assert slip.trial is not None  # an energy can always be put right
        update = {"duration_s": self.duration_s, "record_every": STRIDE}
        scenario = load_scenario(self.scenario).model_copy(update=update)
        sides = (slip.trial.as_printed, slip.trial.put_right)
        printed, right = (side(scenario).simulate() for side in sides)
        apart = tip_position(printed, arm).values - tip_position(right, arm).values
        return {
            "id": f"H4/{self.arm}/{self.scenario}",
            "arm": self.arm,
            "scenario": self.scenario,
            "duration_s": scenario.duration_s,
            "share_of_M_33_kg_m2": slip.size,
            "relative": slip.relative,
            "theta_rad": largest_difference(printed, right, "theta"),
            "tip_m": float(np.linalg.norm(apart, axis=1).max()),
            "mesh_force_N": largest_difference(printed, right, "F_sp"),
        }


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
    largest = max(found, key=lambda record: float(record["tip_m"]))
    verdict = {
        "id": "H4",
        "verdict": "considerable" if matters(largest["tip_m"]) else "not considerable",
        "largest_tip_m": largest["tip_m"],
        "where": f"{largest['arm']}, {largest['scenario']}",
    }
    text = [
        heading("H4: the elbow planets' share of link 1's rotation"),
        paragraph(_question(found[0])),
        table(_HEAD, [_row(record) for record in found]),
        paragraph(_answer(largest, verdict["verdict"])),
    ]
    outcome = f"{verdict['verdict']}, at most {1000 * largest['tip_m']:.2g} mm at the tip."
    return Chapter(ID, TITLE, "\n".join(text), [verdict, *found], outcome)


_HEAD = (
    "reading",
    "scenario",
    "missing in M_33 [kg m²]",
    "Δθ [rad]",
    "tip [mm]",
    "mesh force per planet [N]",
)


def _row(record: dict[str, Any]) -> tuple[str, ...]:
    return (
        record["arm"].removeprefix("paper-"),
        f"{record['scenario']}, {record['duration_s']:g} s",
        f"{record['share_of_M_33_kg_m2']:.3g} ({100 * record['relative']:.2g} %)",
        f"{record['theta_rad']:.3g}",
        f"{1000 * record['tip_m']:.3g}",
        f"{record['mesh_force_N']:.3g}",
    )


def _question(record: dict[str, Any]) -> str:
    return (
        "Question: a planet of the elbow turns with link 1, against which its own angle is counted,"
        " but Eq. 18 gives it the spin of its own joint alone. What does that cost? Experiment:"
        " Eqs. 16 to 19 as printed against the same with this one spin put right, everything else"
        " alike (default damping, phase angle); the energy lacks"
        f" {record['share_of_M_33_kg_m2']:.2g} kg m² in M_33 and the products of the two joints'"
        " rates. Largest difference over the run:"
    )


def _answer(largest: dict[str, Any], verdict: str) -> str:
    return (
        f"At most {1000 * largest['tip_m']:.2g} mm at the tip ({largest['scenario']}, reading"
        f" {largest['arm'].removeprefix('paper-')}) against the {1000 * CONSIDERABLE_M:g} mm that"
        f" Section 3.1 calls considerable. Verdict: the cost is {verdict}."
    )
