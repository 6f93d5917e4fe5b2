"""Hypothesis H5: how heavy must the base be for Section 2's fixed base?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
import xarray as xr

from crosscheck.checks.trajectories import tip_position
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import known
from crosscheck.registry import build
from crosscheck.report.chapter import Chapter, rendered
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS, figure, heading, paragraph, table
from crosscheck.studies.study import Study
from models.loading import Case, load_case, load_scenario
from models.pinocchio_floating import Base, PinocchioFloating

ID, TITLE = "floating_base", "A base that is free to fly (H5)"
READING = "paper-labelled"
FIXED_BASE = "pinocchio:coupled"
SCENARIOS = {"constant-torque": "100 N m, 0.5 s", "pd": "PD to 30°, 3 s"}
SIDES_M = (2.0, 1.0, 4.0)
RATIOS = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 10000.0)
FIXED_TOLERANCE = 1e-10  # relative, of the fixed arm's run
LIMIT_M = 0.03  # what Section 3.1 calls considerable
EVERY = "scenario.record_every=1000"  # 10 ms


def chapter(study: Study, scale: Scale) -> Chapter:
    """Tip error of the fixed base over the base's mass."""
    tasks = [
        _Flights(scenario, side, scale.seconds(load_scenario(scenario).duration_s))
        for scenario in SCENARIOS
        for side in SIDES_M
    ]
    flights = [flight for rows in study.answers(tasks, "H5, free-flying base") for flight in rows]
    needs = [_need(flights, scenario, side) for scenario in SCENARIOS for side in SIDES_M]
    verdict = BaseVerdict(tuple(needs))
    html = [
        _introduction(flights, needs, verdict),
        figure(_drawing(flights), _CAPTION),
        _need_table(needs),
        _flight_table(flights),
    ]
    needed = "; ".join(
        f"{SCENARIOS[scenario]}, {_needed(needs, scenario)} times" for scenario in SCENARIOS
    )
    outcome = f"{verdict.verdict}; needed over the arm's mass: {needed}."
    return Chapter(ID, TITLE, "\n".join(html), rendered((verdict, *needs, *flights)), outcome)


def _needed(needs: Sequence[Need], scenario: str) -> str:
    """Smallest and largest over the cubes."""
    ratios = [need.ratio for need in needs if need.scenario == scenario]
    enough = [ratio for ratio in ratios if ratio is not None]
    if len(enough) < len(ratios):
        return _ratio(None)
    low, high = min(enough), max(enough)
    return _ratio(low) if low == high else f"{_ratio(low)} to {_ratio(high)}"


_CAPTION = (
    "Largest distance over the run between the tip on a free-flying base and on a fixed one,"
    f" inertial frame; dotted: {1000 * LIMIT_M:g} mm. {READING}, rigid gears with rotor coupling."
)


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

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        cube = f"cube {self.side_m:g} m/ratio {self.ratio:g}"
        return {"id": f"floating_base/{self.scenario}/{cube}", **asdict(self)}


@dataclass(frozen=True)
class Need:
    """From which mass ratio on the tip stays within LIMIT_M; None: from none of those flown.

    ratio: over the whole run; error_times_ratio_m: of the heaviest base.
    """

    scenario: str
    side_m: float
    ratio: float | None
    ratio_at_end: float | None
    error_times_ratio_m: float

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        return {
            "id": f"floating_base/needed/{self.scenario}/cube {self.side_m:g} m",
            **asdict(self),
        }


@dataclass(frozen=True)
class BaseVerdict:
    """H5, by what every scenario and cube needs."""

    needs: tuple[Need, ...]

    @property
    def verdict(self) -> str:
        """In words."""
        enough = larger_is_enough([need.ratio for need in self.needs])
        return "a larger base suffices" if enough else "a merely larger base does not suffice"

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        found = [need.ratio for need in self.needs if need.ratio is not None]
        return {
            "id": "H5",
            "verdict": self.verdict,
            "lowest_needed_ratio": min(found, default=None),
            "highest_needed_ratio": max(found) if len(found) == len(self.needs) else None,
        }


@dataclass(frozen=True)
class _Flights:
    """Runs of one scenario on one cube, over its mass."""

    scenario: str
    side_m: float
    duration_s: float

    @property
    def case(self) -> Case:
        settings = [EVERY, f"scenario.duration_s={self.duration_s!r}"]
        return load_case(READING, self.scenario, None, settings)

    @property
    def inputs(self) -> str:
        return "\n".join([repr(self), *(record.model_dump_json() for record in self.case)])

    @property
    def cost(self) -> float:
        return self.duration_s

    def answer(self) -> list[Flight]:
        case = self.case
        fixed = build(FIXED_BASE, *case).reference(FIXED_TOLERANCE)
        return [self._flight(case, fixed, ratio) for ratio in RATIOS]

    def _flight(self, case: Case, fixed: xr.Dataset, ratio: float) -> Flight:
        """ratio: base's mass over that of all that it carries."""
        mass = ratio * arm_mass(case)
        free = PinocchioFloating(case.arm, case.scenario, Base(mass, self.side_m)).simulate()
        error = tip_error(free, fixed, case)
        worst = int(np.argmax(error))
        return Flight(
            scenario=self.scenario,
            side_m=self.side_m,
            ratio=ratio,
            base_mass_kg=mass,
            largest_m=float(error[worst]),
            largest_at_s=float(free["time"].values[worst]),
            end_m=float(error[-1]),
            base_turn_rad=float(free["base"].values[-1, 2]),
            joint_error_rad=float(np.abs(free["theta"] - fixed["theta"]).max()),
            momentum_drift=float(np.abs(free["momentum"]).max()),
        )


def arm_mass(case: Case) -> float:
    """Mass [kg] of all that the base carries."""
    return PinocchioFloating(case.arm, case.scenario, Base(1.0)).arm_mass_kg


def tip_error(free: xr.Dataset, fixed: xr.Dataset, case: Case) -> np.ndarray:
    """Distance [m] (times,) in the inertial frame between the tips on the two bases."""
    local = tip_position(free, case.arm).values
    x, y, angle = free["base"].values.T
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    flying = np.column_stack([x, y]) + np.einsum("ijt,tj->ti", turn, local)
    return np.linalg.norm(flying - tip_position(fixed, case.arm).values, axis=1)


def needed_ratio(ratios: np.ndarray, errors: np.ndarray, limit: float) -> float | None:
    """Ratio from which on the error stays below the limit, between samples by power law.

    The smallest ratio if all are below; None if the largest ratio is not enough. An error that is
    not known is not below.
    """
    above = np.flatnonzero(~(errors < limit))
    if above.size == 0:
        return float(ratios[0])
    last = int(above[-1])
    if last == ratios.size - 1 or not known(errors[last]):
        return None
    near = slice(last, last + 2)
    x, y = np.log(ratios[near]), np.log(errors[near])
    return float(np.exp(np.interp(-np.log(limit), -y, x)))


def larger_is_enough(needs: list[float | None]) -> bool:
    """Whether the smallest base of the sweep keeps every tip within the limit."""
    return all(need is not None and need <= RATIOS[0] for need in needs)


def _need(flights: Sequence[Flight], scenario: str, side: float) -> Need:
    mine = [f for f in flights if (f.scenario, f.side_m) == (scenario, side)]
    ratios = np.array([f.ratio for f in mine])
    largest, end = np.array([(f.largest_m, f.end_m) for f in mine]).T
    return Need(
        scenario=scenario,
        side_m=side,
        ratio=needed_ratio(ratios, largest, LIMIT_M),
        ratio_at_end=needed_ratio(ratios, end, LIMIT_M),
        error_times_ratio_m=float(largest[-1] * ratios[-1]),
    )


def _introduction(flights: Sequence[Flight], needs: Sequence[Need], verdict: BaseVerdict) -> str:
    cases = "; ".join(
        f"{SCENARIOS[need.scenario]}, cube of {need.side_m:g} m: {_ratio(need.ratio)}"
        for need in needs
    )
    mass = flights[0].base_mass_kg / flights[0].ratio
    drift = max(flight.momentum_drift for flight in flights)
    return (
        heading("Question and experiment")
        + paragraph(
            "Section 2 fixes the base since it is heavier than the arm. Here the arm, with rigid"
            " gears that couple their spin to what carries them, stands on a free homogeneous cube"
            " that nothing holds or steers, the shoulder at the middle of a face; Pinocchio works"
            f" out its motion. All that the base carries weighs {mass:.2f} kg. The tip's place in"
            " the inertial frame is compared with that of the same arm on a fixed base, for bases"
            f" of {RATIOS[0]:g} to {RATIOS[-1]:g} times that mass. Momentum, linear and angular,"
            f" drifts by no more than {drift:.0e} N s and N m s in these runs."
        )
        + paragraph(
            f"Verdict: {verdict.verdict}. The tip stays within {1000 * LIMIT_M:g} mm of where a"
            f" fixed base would have it from this many times the arm's mass on: {cases}. For heavy"
            " bases the error falls as one over the mass."
        )
    )


def _ratio(value: float | None) -> str:
    if value is None:
        return f"more than {RATIOS[-1]:g}"
    return f"at most {value:g}" if value == RATIOS[0] else f"{value:.3g}"


def _need_table(needs: Sequence[Need]) -> str:
    rows = [
        [SCENARIOS[need.scenario], f"{need.side_m:g}", _ratio(need.ratio),
         _ratio(need.ratio_at_end), f"{need.error_times_ratio_m:.3g}"]
        for need in needs
    ]  # fmt: skip
    head = ["scenario", "cube [m]", "mass ratio, whole run", "mass ratio, at the end",
            "error times ratio for a heavy base [m]"]  # fmt: skip
    return table(head, rows, f"Base mass over arm mass from which the tip error is < {LIMIT_M:g} m")


def _flight_table(flights: Sequence[Flight]) -> str:
    rows = [
        [f.scenario, f"{f.side_m:g}", f"{f.ratio:g}", f"{f.base_mass_kg:.4g}",
         f"{1000 * f.largest_m:.3g}", f"{f.largest_at_s:.2f}", f"{1000 * f.end_m:.3g}",
         f"{f.base_turn_rad:.3g}", f"{f.joint_error_rad:.2g}"]
        for f in flights if f.side_m == SIDES_M[0]
    ]  # fmt: skip
    head = ["scenario", "cube [m]", "ratio", "base [kg]", "largest tip error [mm]", "at [s]",
            "at the end [mm]", "base turned [rad]", "joint angles moved [rad]"]  # fmt: skip
    return table(head, rows, "The default cube, run by run")


def _drawing(flights: Sequence[Flight]) -> str:
    picture, grid = new_figure(1, len(SCENARIOS), 2.9)
    for axes, scenario in zip(grid[0], SCENARIOS, strict=True):
        for side, colour in zip(SIDES_M, COLOURS, strict=False):
            mine = [f for f in flights if (f.scenario, f.side_m) == (scenario, side)]
            points = [(f.ratio, 1000 * f.largest_m) for f in mine]
            axes.plot(*np.array(points).T, "o-", color=colour, ms=3, label=f"cube {side:g} m")
        axes.axhline(1000 * LIMIT_M, color="#555555", linestyle=":")
        axes.set(xscale="log", yscale="log", xlabel="base mass / arm mass",
                 ylabel="largest tip error [mm]", title=SCENARIOS[scenario])  # fmt: skip
    legend(picture, grid[0, 0])
    return to_svg(picture)
