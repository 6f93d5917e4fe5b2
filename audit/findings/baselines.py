"""What makes the rigid baseline of Figs. 6-7 deviate from the detailed arm.

A chain of models goes from the links alone to the paper's detailed arm, one change each: the rigid
levels, the compliant teeth of the corrected equations, the printed ones, their clock. What each
adds takes every deviation apart.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from crosscheck.audit.claims.catalogue import BY_ID
from crosscheck.audit.experiments.courses import simulate_courses
from crosscheck.audit.experiments.paper_conditions import LABELLED, READINGS
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.torque import find_tip
from crosscheck.audit.experiments.variant import GEARED_MODELS, Variant
from crosscheck.audit.judging.rule import Claim
from crosscheck.audit.measures.rigid import rigid_model
from crosscheck.audit.measures.undefined import (
    JsonObject,
    extreme_value,
    quotient,
    to_json,
)
from crosscheck.registry import RIGID_LEVELS
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import draw_legend, make_figure, to_svg

MASSES, INERTIA, MESHES, SLIPS = "masses", "inertia", "meshes", "slips"
# The chain's models with the laws of their phases, and what every one adds to the one before.
MODELS = (
    *((rigid_model(level), "angle") for level in RIGID_LEVELS),
    (GEARED_MODELS["corrected"], "angle"),
    (GEARED_MODELS["printed"], "angle"),
    (GEARED_MODELS["printed"], "omega_t"),
)
ADDED = (MASSES, INERTIA, INERTIA, MESHES, SLIPS, MESHES)
LEVELS = {
    "links": "links, payload",
    "carriers": "links, payload, joint masses",
    "armature": "these, reflected inertia",
    "coupled": "these, its coupling",
}


class PrintedDeviation(NamedTuple):
    """A deviation that Section 3.1 says of Fig. 6: its unit here, the claim that judges it.

    factor: from the unit here to the claim's.
    """

    symbol: str
    unit: str
    claim: Claim
    claim_unit: str
    factor: float


QUANTITIES = {
    "theta_1": PrintedDeviation("θ₁", "rad", BY_ID["3.1-01"], "rad", 1.0),
    "theta_2": PrintedDeviation("θ₂", "rad", BY_ID["3.1-02"], "rad", 1.0),
    "tip": PrintedDeviation("tip", "m", BY_ID["3.1-04"], "mm", 1e3),
}
ZETA = 0.05  # the arm's own
RECORD = 100  # 1 ms
NEARLY_ALL = 0.9  # of a deviation


def run_chain(study: Study, arm: str, scale: Scale) -> np.ndarray:
    """What every model of the chain adds, (steps, times, quantities). Raises Diverged."""
    chain = [
        scale.cut(
            Variant(
                "constant-torque", arm, phase=phase, zeta=ZETA, model=model, record_every=RECORD
            )
        )
        for model, phase in MODELS
    ]
    runs = simulate_courses(study, chain, f"rigid baselines, {arm}")
    # theta_1, theta_2 [rad] and the tip's x, y [m], (times, 4).
    tips = {each: find_tip(runs[each].theta, runs[each].case.arm) for each in chain}
    return compute_contributions(
        [np.column_stack([runs[each].theta, tips[each].real, tips[each].imag]) for each in chain]
    )


def compute_contributions(places: list[np.ndarray]) -> np.ndarray:
    """What every model adds, (steps, times, 3), from places (times, 4) of each in turn.

    The tip's steps are projected on the direction of the whole deviation, so that they too sum to
    the total.
    """
    steps = np.diff(np.array(places), axis=0)
    whole = places[-1][:, 2:] - places[0][:, 2:]
    distance = np.linalg.norm(whole, axis=1, keepdims=True)
    direction = np.divide(whole, distance, out=np.zeros_like(whole), where=distance > 0)
    towards = np.einsum("rta,ta->rt", steps[:, :, 2:], direction)
    return np.concatenate([steps[:, :, :2], towards[:, :, None]], axis=2)


@dataclass(frozen=True)
class RigidResidual:
    """A rigid baseline's largest deviations under constant torque.

    totals: by quantity [rad, m]; shares: by quantity, each group's signed part, nan of a total 0.
    """

    arm: str
    level: str
    totals: Mapping[str, float]
    shares: Mapping[str, Mapping[str, float]]

    @property
    def fits(self) -> dict[str, bool]:
        """Whether each deviation is what the paper says, by quantity."""
        return {
            name: quantity.claim.limits.count_inside([quantity.factor * abs(self.totals[name])])
            == 1
            for name, quantity in QUANTITIES.items()
        }

    def to_dict(self) -> JsonObject:
        """The baseline as a JSON object."""
        sizes = {
            f"{name}_{QUANTITIES[name].unit}": abs(total) for name, total in self.totals.items()
        }
        where = f"finding/baseline/{self.arm}/{self.level}"
        return {"id": where, **to_json(sizes), "as_in_the_paper": to_json(self.fits)}


def measure_residual(arm: str, level: str, steps: np.ndarray) -> RigidResidual:
    """What a rigid level leaves of what the whole chain adds: the steps above it.

    steps (steps, times, quantities).
    """
    first = RIGID_LEVELS.index(level)
    left, totals, shares = steps[first:], dict[str, float](), dict[str, dict[str, float]]()
    for number, quantity in enumerate(QUANTITIES):
        course = left[:, :, number].sum(axis=0)
        at = left[:, int(np.argmax(np.abs(course))), number].tolist()
        totals[quantity] = sum(at)
        shares[quantity] = {
            group: quotient(
                sum(part for name, part in zip(ADDED[first:], at, strict=True) if name == group),
                totals[quantity],
            )
            for group in dict.fromkeys(ADDED)
        }
    return RigidResidual(arm, level, totals, shares)


@dataclass(frozen=True)
class BaselineFinding:
    """What every rigid arm leaves under constant torque."""

    residuals: tuple[RigidResidual, ...]

    @property
    def fitting(self) -> tuple[str, ...]:
        """The levels that leave the paper's theta_2 in all readings."""
        fits = [(residual.level, residual.fits["theta_2"]) for residual in self.residuals]
        return tuple(
            level for level in RIGID_LEVELS if {f for at, f in fits if at == level} == {True}
        )

    def list_shares(self, group: str) -> list[float]:
        """The shares of a group of changes in all that the fitting levels leave."""
        fitting = [residual for residual in self.residuals if residual.level in self.fitting]
        return [shares[group] for residual in fitting for shares in residual.shares.values()]

    @property
    def holds(self) -> bool | None:
        """Whether nearly all that fitting levels leave is reflected inertia; None if undefined."""
        least = extreme_value(self.list_shares(INERTIA), min)
        return None if np.isnan(least) else least >= NEARLY_ALL

    @property
    def most_meshes(self) -> float:
        """Largest share of all the meshes' effects in it."""
        return extreme_value(map(abs, self.list_shares(MESHES)), max)

    @property
    def nearest(self) -> RigidResidual | None:
        """The first baseline that leaves the paper's theta_2, labelled reading, if one does."""
        return next((x for x in self.residuals if x.arm == LABELLED and x.fits["theta_2"]), None)

    @property
    def gives_all(self) -> bool:
        """Whether one baseline leaves all of the paper's numbers."""
        return any(all(residual.fits.values()) for residual in self.residuals)


def compare_baselines(study: Study, scale: Scale) -> BaselineFinding:
    """The finding on the rigid baselines; quick: of the labelled reading alone."""
    arms = [LABELLED] if scale.quick else list(READINGS)
    steps_by_arm = {arm: run_chain(study, arm, scale) for arm in arms}
    return BaselineFinding(
        tuple(
            measure_residual(arm, level, steps)
            for arm, steps in steps_by_arm.items()
            for level in RIGID_LEVELS
        )
    )


def draw_baselines(residuals: Sequence[RigidResidual]) -> str:
    """The sizes of what every baseline leaves, beside what the paper says, as svg."""
    figure, grid = make_figure(1, len(QUANTITIES), 2.6)
    for axes, (name, quantity) in zip(grid[0], QUANTITIES.items(), strict=True):
        limits = quantity.claim.limits
        axes.axvspan(limits.low, limits.high, color="#999999", alpha=0.3, label="paper")
        for arm, marker, colour in zip(READINGS, "os", COLOURS, strict=False):
            arm_residuals = [residual for residual in residuals if residual.arm == arm]
            sizes = [quantity.factor * abs(residual.totals[name]) for residual in arm_residuals]
            rows = [RIGID_LEVELS.index(residual.level) for residual in arm_residuals]
            axes.plot(sizes, rows, marker, color=colour, ms=5, label=READINGS[arm])
        label = f"left of {quantity.symbol} [{quantity.claim_unit}]"
        axes.set(xscale="log", xlabel=label, yticks=[])
        axes.set_ylim(len(RIGID_LEVELS) - 0.5, -0.5)
    grid[0, 0].set_yticks(range(len(RIGID_LEVELS)), [LEVELS[level] for level in RIGID_LEVELS])
    draw_legend(figure, grid[0, 0])
    return to_svg(figure)
