"""Fig. 15's experiment, back and forth: what backlash adds, and the rigid arm's own sensitivity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crosscheck.audit.claims.study_plan import ResultsByCondition
from crosscheck.audit.experiments.experiments import BACK, BACK_EVEN, DEFAULT_B_UM, ExperimentSeries
from crosscheck.audit.experiments.paper_conditions import AS_GEARS, Condition
from crosscheck.audit.experiments.torque import ERROR_WINDOWS_S
from crosscheck.audit.judging.quantities import ConditionResults
from crosscheck.audit.judging.rule import State, share_of, state

# 2000 sin(20 pi sqrt(t)) as printed, 2000 sin(20 pi t).
DRIVES = {"sqrt_time": BACK, "time": BACK_EVEN}
EARLY, LATE = "early", "2_s"  # of ERROR_WINDOWS_S
APART_S = float(np.mean(ERROR_WINDOWS_S[LATE]) - np.mean(ERROR_WINDOWS_S[EARLY]))
SAME_RATE = 0.25  # relative


@dataclass(frozen=True)
class Accumulation:
    """What backlash adds to the shoulder's error in one setting, of every start (starts,).

    added_rad: to the largest error in LATE; growth_per_s [1/s]: of what is added, from EARLY on;
    rigid_growth_per_s [1/s]: of the error of a rigid arm that starts a little away.
    """

    condition: Condition
    added_rad: np.ndarray
    growth_per_s: np.ndarray
    rigid_growth_per_s: np.ndarray

    @property
    def state(self) -> State:
        """Whether both grow at the same rate."""
        with np.errstate(all="ignore"):
            gaps = np.abs(self.growth_per_s / self.rigid_growth_per_s - 1)
        return state(share_of(bool(gap <= SAME_RATE) for gap in gaps if np.isfinite(gap)))


def measure_accumulation(
    condition: Condition, results: ConditionResults, series: ExperimentSeries
) -> Accumulation:
    """What backlash adds by one drive, from a setting's experiments.

    Start i with backlash is compared with start i without.
    """
    exact, backlash = results[series(0.0)], results[series(DEFAULT_B_UM)]
    early, late = (backlash[f"error_{when}"] - exact[f"error_{when}"] for when in (EARLY, LATE))
    rigid_early, rigid_late = (backlash[f"own_{when}"] for when in (EARLY, LATE))
    with np.errstate(all="ignore"):
        growth, rigid_growth = np.log([late / early, rigid_late / rigid_early]) / APART_S
    return Accumulation(condition, late, growth, rigid_growth)


def find_accumulations(settings: ResultsByCondition) -> dict[str, list[Accumulation]]:
    """What backlash adds as the gears are, by drive, in every setting that was driven so."""
    return {
        drive: [
            measure_accumulation(condition, results, series)
            for condition, results in settings
            if condition.model == AS_GEARS and series(DEFAULT_B_UM) in results
        ]
        for drive, series in DRIVES.items()
    }


def judge_drive(accumulations: Sequence[Accumulation]) -> State | None:
    """Whether the growth is the rigid arm's own, if all settings agree; else None."""
    states = {each.state for each in accumulations}
    return states.pop() if len(states) == 1 else None
