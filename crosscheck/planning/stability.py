"""Whether a controlled arm's teeth are stable while they touch, before anything runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import PdDrive, Scenario, per_joint
from crosscheck.registry import build, lead

ROUNDING = 1e-9  # of the fastest pole: what is left of zero
TOLERATED = 0.1  # growth over a whole run, as the exponent of e: it changes no verdict


@dataclass(frozen=True)
class GrowingMode:
    """A mode of the closed loop that grows with the teeth in contact: its rate and frequency."""

    rate_per_s: float
    frequency_Hz: float

    def __str__(self) -> str:
        grows = f"{self.rate_per_s:+.3g} 1/s at {self.frequency_Hz:.4g} Hz"
        return f"the loop is unstable while teeth touch: {grows}"


def growth_of(arm: Arm, scenario: Scenario) -> GrowingMode | None:
    """The fastest-growing vibration of a scenario's loop, at its start and its target.

    None if none grows to speak of within its duration. A fall is no vibration.
    """
    found = [_growth(arm, posed) for posed in _poses(arm, scenario)]
    worst = max(found, key=lambda growth: growth.rate_per_s)
    return worst if worst.rate_per_s * scenario.duration_s > TOLERATED else None


def _growth(arm: Arm, scenario: Scenario) -> GrowingMode:
    poles = build(lead(), arm, scenario, usual_switches(arm)).contact_poles()
    vibrations = poles[poles.imag > ROUNDING * np.abs(poles).max()]
    if not vibrations.size:
        return GrowingMode(0.0, 0.0)
    worst = vibrations[np.argmax(vibrations.real)]
    rate = float(worst.real) if worst.real > ROUNDING * np.abs(poles).max() else 0.0
    return GrowingMode(rate, float(worst.imag) / (2 * np.pi))


def _poses(arm: Arm, scenario: Scenario) -> list[Scenario]:
    poses = [scenario]
    if isinstance(scenario.drive, PdDrive):
        there = per_joint(scenario.drive.target_rad, len(arm.joints))
        start = scenario.start.model_copy(update={"theta_rad": there})
        poses.append(scenario.model_copy(update={"start": start}))
    return poses
