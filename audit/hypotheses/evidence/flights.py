"""The arm on a base that is free to fly: how far its tip is from where a fixed base has it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from crosscheck.audit.experiments.question import Question, Records
from crosscheck.audit.measures.undefined import is_defined
from crosscheck.checks.trajectories import tip_position
from crosscheck.models.loading import Case, load_case
from crosscheck.models.pinocchio.floating import FloatingBase, PinocchioFloating
from crosscheck.registry import build

READING = "paper-labelled"
FIXED_BASE = "pinocchio:coupled"
SCENARIOS = ("constant-torque", "pd")
SIDES_M = (2.0, 1.0, 4.0)
RATIOS = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 10000.0)
FIXED_TOLERANCE = 1e-10  # relative, of the fixed arm's run
LIMIT_M = 0.03  # what Section 3.1 calls considerable
EVERY = "scenario.record_every=1000"  # 10 ms


@dataclass(frozen=True)
class Flight:
    """A run on a free cube of a side, of so many times the mass of all that it carries.

    largest_m, end_m: the tip's distance from where a fixed base would have it; base_turn_rad: at
    the end; joint_error_rad: largest; momentum_drift: largest, N s and N m s.
    """

    scenario: str
    side_m: float
    ratio: float
    base_mass_kg: float
    largest_m: float
    largest_at_s: float
    end_m: float
    base_turn_rad: float
    joint_error_rad: float
    momentum_drift: float


@dataclass(frozen=True)
class RequiredMassRatio:
    """The mass ratio from which on the tip stays within LIMIT_M; None if no base flown is enough.

    ratio: over the whole run; error_times_ratio_m: of the heaviest base.
    """

    scenario: str
    side_m: float
    ratio: float | None
    ratio_at_end: float | None
    error_times_ratio_m: float


@dataclass(frozen=True)
class FlightSweep(Question[list[Flight]]):
    """A question: the flights in one scenario on one cube, over its mass."""

    cost = 3.0

    scenario: str
    side_m: float
    duration_s: float

    @property
    def case(self) -> Case:
        settings = [EVERY, f"scenario.duration_s={self.duration_s!r}"]
        return load_case(READING, self.scenario, None, settings)

    def records(self) -> Records:
        return self.case

    def answer(self) -> list[Flight]:
        case = self.case
        fixed, carried_kg = simulate_fixed_base(case), arm_mass(case)
        flights = []
        for ratio in RATIOS:
            base = FloatingBase(ratio * carried_kg, self.side_m)
            free = PinocchioFloating(case.arm, case.scenario, base).simulate()
            error = tip_error(free, fixed, case)
            worst = int(np.argmax(error))
            flight = Flight(
                scenario=self.scenario,
                side_m=self.side_m,
                ratio=ratio,
                base_mass_kg=ratio * carried_kg,
                largest_m=float(error[worst]),
                largest_at_s=float(free["time"].values[worst]),
                end_m=float(error[-1]),
                base_turn_rad=float(free["base"].values[-1, 2]),
                joint_error_rad=float(np.abs(free["theta"] - fixed["theta"]).max()),
                momentum_drift=float(np.abs(free["momentum"]).max()),
            )
            flights.append(flight)
        return flights


def simulate_fixed_base(case: Case) -> xr.Dataset:
    """The run of the same arm on a base that does not move."""
    return build(FIXED_BASE, *case).reference(FIXED_TOLERANCE)


def arm_mass(case: Case) -> float:
    """Mass [kg] of all that the base carries."""
    return PinocchioFloating(case.arm, case.scenario, FloatingBase(1.0)).arm_mass_kg


def tip_error(free: xr.Dataset, fixed: xr.Dataset, case: Case) -> np.ndarray:
    """Distance [m] (times,) in the inertial frame between the tips on the two bases."""
    local = tip_position(free, case.arm).values
    x, y, angle = free["base"].values.T
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    flying = np.column_stack([x, y]) + np.einsum("ijt,tj->ti", turn, local)
    return np.linalg.norm(flying - tip_position(fixed, case.arm).values, axis=1)


def required_ratio(ratios: np.ndarray, errors: np.ndarray, limit: float) -> float | None:
    """Ratio from which on the error stays below the limit, between samples by power law.

    The smallest ratio if all are below; None if the largest ratio is not enough. An error that is
    not known is not below.
    """
    above = np.flatnonzero(~(errors < limit))
    if above.size == 0:
        return float(ratios[0])
    last = int(above[-1])
    if last == ratios.size - 1 or not is_defined(errors[last]):
        return None
    near = slice(last, last + 2)
    x, y = np.log(ratios[near]), np.log(errors[near])
    return float(np.exp(np.interp(-np.log(limit), -y, x)))


def is_larger_base_enough(needs: list[float | None]) -> bool:
    """Whether the smallest base of the sweep keeps every tip within the limit."""
    return all(need is not None and need <= RATIOS[0] for need in needs)


def find_required_ratio(flown: Sequence[Flight]) -> RequiredMassRatio:
    """The mass ratio that one scenario on one cube needs, from flights with ever heavier bases."""
    ratios, largest, end = np.array([(f.ratio, f.largest_m, f.end_m) for f in flown]).T
    return RequiredMassRatio(
        scenario=flown[0].scenario,
        side_m=flown[0].side_m,
        ratio=required_ratio(ratios, largest, LIMIT_M),
        ratio_at_end=required_ratio(ratios, end, LIMIT_M),
        error_times_ratio_m=float(largest[-1] * ratios[-1]),
    )
