"""What makes the rigid baseline of Figs. 6-7 deviate from the detailed arm.

The levels go from a rigid arm to the paper's detailed one, one change of the model each. A model is
a set of features. Joint masses are taken away by setting them to zero in the arm's data; three
features can stand on others only: the coupling on the reflected inertia, the teeth's compliance on
both, and backlash, stiffness variation, tooth error, the paper's clock and its errata on the
compliance. What each level adds takes every deviation apart.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from crosscheck.audit.claims.catalogue import BY_ID
from crosscheck.audit.experiments.courses import simulate_courses
from crosscheck.audit.experiments.paper_conditions import LABELLED, READINGS
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.torque import find_tip
from crosscheck.audit.experiments.variant import Variant
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

MASSES, DIAGONAL, COUPLING, COMPLIANCE = "masses", "diagonal", "coupling", "compliance"
BACKLASH, STIFFNESS, ERROR, SLIPS, CLOCK = "backlash", "stiffness", "error", "slips", "clock"
ORDER = (MASSES, DIAGONAL, COUPLING, COMPLIANCE, BACKLASH, STIFFNESS, ERROR, SLIPS, CLOCK)
INERTIA, MESHES = "inertia", "meshes"
GROUPS = {
    "masses": (MASSES,),
    INERTIA: (DIAGONAL, COUPLING),
    MESHES: (COMPLIANCE, BACKLASH, STIFFNESS, ERROR, CLOCK),
    "slips": (SLIPS,),
}
LEVELS = {
    "links": "links, payload",
    "carriers": "links, payload, joint masses",
    "armature": "these, reflected inertia",
    "coupled": "these, its coupling",
}
QUANTITIES = {"theta_1": "rad", "theta_2": "rad", "tip": "m"}
SYMBOLS = {"theta_1": "θ₁", "theta_2": "θ₂", "tip": "tip"}
ZETA = 0.05  # the arm's own
RECORD = 100  # 1 ms

_DEAD_WEIGHT = (
    "sun_mass_kg",
    "planet_mass_kg",
    "carrier_mass_kg",
    "ring_mass_kg",
    "carrier_equivalent_mass_kg",
)
_SWITCHED_BY = {
    BACKLASH: "*_mesh.backlash_m",
    STIFFNESS: "*_mesh.stiffness.amplitude_N_per_m",
    ERROR: "*_mesh.tooth_error_m",
}
# What Section 3.1 says of Fig. 6, each by the claim that judges it.
CLAIMS = {"theta_1": "3.1-01", "theta_2": "3.1-02", "tip": "3.1-04"}
IN_UNIT_OF_CLAIM = {"theta_1": 1.0, "theta_2": 1.0, "tip": 1e3}  # the tip's is in mm
NEARLY_ALL = 0.9  # of a deviation


def find_claims() -> dict[str, Claim]:
    """The claims of the paper's three numbers, by quantity."""
    return {quantity: BY_ID[name] for quantity, name in CLAIMS.items()}


def build_variant(features: frozenset[str], arm: str) -> Variant:
    """The simulation of a model that has these features, under constant torque."""
    absent = [name for feature, name in _SWITCHED_BY.items() if feature not in features]
    if MASSES not in features:
        absent += _DEAD_WEIGHT
    if COMPLIANCE in features:
        model = "analytic:printed" if SLIPS in features else "analytic:physical"
    elif DIAGONAL in features:
        model = rigid_model("coupled" if COUPLING in features else "armature")
    else:
        model = rigid_model("carriers" if MASSES in features else "links")
    return Variant(
        "constant-torque",
        arm,
        phase="omega_t" if CLOCK in features else "angle",
        zeta=ZETA,
        model=model,
        settings=tuple(f"arm.joints.*.{name}=0.0" for name in absent),
        record_every=RECORD,
    )


def iterate_features() -> Iterator[frozenset[str]]:
    """The features of the lowest model, then of every level, each with one more."""
    for count in range(len(ORDER) + 1):
        yield frozenset(ORDER[:count])


def run_ablation(study: Study, arm: str, scale: Scale) -> np.ndarray:
    """What every feature of ORDER adds, (features, times, quantities). Raises Diverged."""
    chain = [scale.cut(build_variant(features, arm)) for features in iterate_features()]
    runs = simulate_courses(study, chain, f"rigid baselines, {arm}")
    # theta_1, theta_2 [rad] and the tip's x, y [m], (times, 4).
    tips = {each: find_tip(runs[each].theta, runs[each].case.arm) for each in chain}
    return compute_contributions(
        [np.column_stack([runs[each].theta, tips[each].real, tips[each].imag]) for each in chain]
    )


def compute_contributions(places: list[np.ndarray]) -> np.ndarray:
    """What every level adds, (levels, times, 3), from places (times, 4) of each model in turn.

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
        claims = find_claims()
        sizes = {name: abs(total) * IN_UNIT_OF_CLAIM[name] for name, total in self.totals.items()}
        return {name: claims[name].limits.count_inside([size]) == 1 for name, size in sizes.items()}

    def to_dict(self) -> JsonObject:
        """The baseline as a JSON object."""
        sizes = {f"{name}_{QUANTITIES[name]}": abs(total) for name, total in self.totals.items()}
        where = f"finding/baseline/{self.arm}/{self.level}"
        return {"id": where, **to_json(sizes), "as_in_the_paper": to_json(self.fits)}


def measure_residual(arm: str, level: str, steps: np.ndarray) -> RigidResidual:
    """What a rigid level leaves of what all features add: those above it, the lowest are its own.

    steps (features, times, quantities).
    """
    first = RIGID_LEVELS.index(level)
    left, totals, shares = steps[first:], dict[str, float](), dict[str, dict[str, float]]()
    for number, quantity in enumerate(QUANTITIES):
        course = left[:, :, number].sum(axis=0)
        at = left[:, int(np.argmax(np.abs(course))), number]
        by_feature = dict(zip(ORDER[first:], map(float, at), strict=True))
        totals[quantity] = sum(by_feature.values())
        shares[quantity] = {
            group: quotient(sum(by_feature.get(name, 0.0) for name in members), totals[quantity])
            for group, members in GROUPS.items()
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
        """The shares of a group of features in all that the fitting levels leave."""
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
    steps_by_arm = {arm: run_ablation(study, arm, scale) for arm in arms}
    return BaselineFinding(
        tuple(
            measure_residual(arm, level, steps)
            for arm, steps in steps_by_arm.items()
            for level in RIGID_LEVELS
        )
    )


def draw_baselines(residuals: Sequence[RigidResidual]) -> str:
    """The sizes of what every baseline leaves, beside what the paper says, as svg."""
    limits = {name: claim.limits for name, claim in find_claims().items()}
    figure, grid = make_figure(1, len(QUANTITIES), 2.6)
    for axes, (name, factor) in zip(grid[0], IN_UNIT_OF_CLAIM.items(), strict=True):
        axes.axvspan(limits[name].low, limits[name].high, color="#999999", alpha=0.3, label="paper")
        for arm, marker, colour in zip(READINGS, "os", COLOURS, strict=False):
            arm_residuals = [residual for residual in residuals if residual.arm == arm]
            sizes = [factor * abs(residual.totals[name]) for residual in arm_residuals]
            rows = [RIGID_LEVELS.index(residual.level) for residual in arm_residuals]
            axes.plot(sizes, rows, marker, color=colour, ms=5, label=READINGS[arm])
        unit = "mm" if name == "tip" else "rad"
        axes.set(xscale="log", xlabel=f"left of {SYMBOLS[name]} [{unit}]", yticks=[])
        axes.set_ylim(len(RIGID_LEVELS) - 0.5, -0.5)
    grid[0, 0].set_yticks(range(len(RIGID_LEVELS)), [LEVELS[level] for level in RIGID_LEVELS])
    draw_legend(figure, grid[0, 0])
    return to_svg(figure)
