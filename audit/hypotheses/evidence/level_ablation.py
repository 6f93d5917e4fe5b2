"""The levels from a rigid arm to the paper's detailed one: one change of the model each.

A model is a set of features. Joint masses are taken away by setting them to zero in the arm's data,
so every order of levels uses the project's own models; three features can stand on others only: the
coupling on the reflected inertia, the teeth's compliance on both, and backlash, stiffness
variation, tooth error, the paper's clock and its errata on the compliance. What each level adds
takes every deviation apart, and gives the verdicts of H2.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Literal, NamedTuple, get_args

import numpy as np

from crosscheck.audit.claims.rule import Claim, Limits
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.reading import select_angles
from crosscheck.audit.measures.rigid import rigid_model
from crosscheck.audit.measures.undefined import (
    UNDEFINED,
    extreme_value,
    is_defined,
    propagate_undefined,
    quotient,
)
from crosscheck.checks.trajectories import SAFETY, tip_position
from crosscheck.registry import RIGID_LEVELS

MASSES, DIAGONAL, COUPLING, COMPLIANCE = "masses", "diagonal", "coupling", "compliance"
BACKLASH, STIFFNESS, ERROR, SLIPS, CLOCK = "backlash", "stiffness", "error", "slips", "clock"
CARRIED, INERTIA, MESHES, SLIPPED = "masses", "inertia", "meshes", "slips"
GROUPS = {
    CARRIED: (MASSES,),
    INERTIA: (DIAGONAL, COUPLING),
    MESHES: (COMPLIANCE, BACKLASH, STIFFNESS, ERROR, CLOCK),
    SLIPPED: (SLIPS,),
}
ORDERS = {
    "A": (MASSES, DIAGONAL, COUPLING, COMPLIANCE, BACKLASH, STIFFNESS, ERROR, SLIPS, CLOCK),
    "B": (DIAGONAL, COUPLING, COMPLIANCE, ERROR, STIFFNESS, BACKLASH, CLOCK, SLIPS, MASSES),
}
QUANTITIES = {"theta_1": "rad", "theta_2": "rad", "tip": "m"}
PRINTED, PHYSICAL = "analytic:printed", "analytic:physical"
FINE, COARSE = (1e-5, 100), (2e-5, 50)  # step [s], steps between records: 1 ms either way
ZETA = 0.05  # the arm's own

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
TORQUE = "constant-torque"
NEARLY_ALL = 0.9  # of a deviation
Instant = Literal["end", "largest"]


def build_variant(
    features: frozenset[str], scenario: str, arm: str, grid: tuple[float, int] = FINE
) -> Variant:
    """The simulation of a model that has these features."""
    absent = [name for feature, name in _SWITCHED_BY.items() if feature not in features]
    if MASSES not in features:
        absent += _DEAD_WEIGHT
    if COMPLIANCE in features:
        model = PRINTED if SLIPS in features else PHYSICAL
    elif DIAGONAL in features:
        model = rigid_model("coupled" if COUPLING in features else "armature")
    else:
        model = rigid_model("carriers" if MASSES in features else "links")
    step, stride = grid
    settings = tuple(f"arm.joints.*.{name}=0.0" for name in absent)
    return Variant(
        scenario,
        arm,
        phase="omega_t" if CLOCK in features else "angle",
        zeta=ZETA,
        model=model,
        settings=(*settings, f"scenario.step_s={step!r}"),
        record_every=stride,
    )


def iterate_features(order: tuple[str, ...]) -> Iterator[frozenset[str]]:
    """The features of the lowest model, then of every level, each with one more."""
    for count in range(len(order) + 1):
        yield frozenset(order[:count])


@dataclass(frozen=True)
class LevelAblation:
    """An ablation: what every level adds to the deviation of the detailed arm from the rigid one.

    order: its name in ORDERS; level: the rigid one that it begins at; names: of its levels,
    upwards; time (times,) [s]; fine, coarse (levels, times, quantities) [rad, rad, m] at two steps.
    """

    scenario: str
    arm: str
    order: str
    level: str
    names: tuple[str, ...]
    time: np.ndarray
    fine: np.ndarray
    coarse: np.ndarray

    @property
    def uncertainty(self) -> np.ndarray:
        """Numerical uncertainty of every contribution, (levels, times, quantities)."""
        return SAFETY * np.abs(self.fine - self.coarse)

    @property
    def total(self) -> np.ndarray:
        """The whole deviation, (times, quantities); the tip's is its magnitude [m]."""
        return self.fine.sum(axis=0)

    def largest_index(self, quantity: int) -> int:
        """Index of the time at which the deviation of a quantity is largest."""
        return int(np.argmax(np.abs(self.total[:, quantity])))

    def start_at_level(self, level: str) -> LevelAblation:
        """What a baseline of a level leaves; in order A the levels are the lowest levels."""
        first = RIGID_LEVELS.index(level)
        upper = {name: getattr(self, name)[first:] for name in ("names", "fine", "coarse")}
        return replace(self, level=level, **upper)

    def shares(self, index: int, quantity: int) -> dict[str, float]:
        """Each group's signed part of the whole at a time; they sum to 1, or are nan if it is 0."""
        at = dict(zip(self.names, map(float, self.fine[:, index, quantity]), strict=True))
        whole = sum(at.values())
        return {
            group: quotient(sum(at.get(name, 0.0) for name in members), whole)
            for group, members in GROUPS.items()
        }


def run_ablation(study: Study, scenario: str, arm: str, order: str, scale: Scale) -> LevelAblation:
    """The ablation of a scenario, an arm and an order, run at both steps. Raises Diverged."""
    chain = list(iterate_features(ORDERS[order]))
    fine, coarse = (
        [scale.cut(build_variant(model, scenario, arm, grid)) for model in chain]
        for grid in (FINE, COARSE)
    )
    runs = study.run_variants([*fine, *coarse], f"ladder {order}, {scenario}, {arm}", select_angles)
    geometry = fine[0].case().arm
    # theta_1, theta_2 [rad] and the tip's x, y [m], (times, 4).
    places = {
        model: np.hstack([run["theta"].values, tip_position(run, geometry).values])
        for model, run in runs.items()
    }
    parts = [contributions([places[model] for model in row]) for row in (fine, coarse)]
    time = runs[fine[0]]["time"].values
    return LevelAblation(scenario, arm, order, RIGID_LEVELS[0], ORDERS[order], time, *parts)


def contributions(places: list[np.ndarray]) -> np.ndarray:
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


class Contribution(NamedTuple):
    """A level's part of a deviation and its numerical uncertainty [rad or m]."""

    name: str
    contribution: float
    uncertainty: float


@dataclass(frozen=True)
class Deviation:
    """The detailed arm's deviation from a rigid level at an instant, divided by levels.

    total [rad or m]; shares: of every group of levels, nan if the total is 0.
    """

    arm: str
    scenario: str
    order: str
    level: str
    quantity: str
    instant: Instant
    time_s: float
    total: float
    contributions: tuple[Contribution, ...]
    shares: Mapping[str, float]

    @property
    def where(self) -> str:
        """The part of the id that names what deviates, from which level and when."""
        return f"{self.arm}/{self.scenario}/{self.order}/{self.level}/{self.instant}"

    @property
    def dominant(self) -> str:
        """The group that alone explains nearly all of the deviation, if there is one."""
        if not is_defined(*self.shares.values()):
            return UNDEFINED
        alone = [group for group, share in self.shares.items() if share >= NEARLY_ALL]
        return alone[0] if len(alone) == 1 else "none alone"

    def fits(self, limits: Limits) -> bool:
        """Whether the deviation's size is what the paper says."""
        size = abs(self.total) * IN_UNIT_OF_CLAIM[self.quantity]
        return bool(limits.contains(np.array([size]))[0])


def compute_deviations(ablation: LevelAblation) -> list[Deviation]:
    """The deviations of every quantity at the end and at its largest."""
    deviations = []
    for (number, quantity), instant in product(enumerate(QUANTITIES), get_args(Instant)):
        index = -1 if instant == "end" else ablation.largest_index(number)
        parts = [map(float, x[:, index, number]) for x in (ablation.fine, ablation.uncertainty)]
        deviation = Deviation(
            arm=ablation.arm,
            scenario=ablation.scenario,
            order=ablation.order,
            level=ablation.level,
            quantity=quantity,
            instant=instant,
            time_s=float(ablation.time[index]),
            total=float(ablation.total[index, number]),
            contributions=tuple(map(Contribution, ablation.names, *parts)),
            shares=ablation.shares(index, number),
        )
        deviations.append(deviation)
    return deviations


def compute_baseline_deviations(ablations: Iterable[LevelAblation]) -> list[Deviation]:
    """What every rigid baseline leaves, from ladders in order A."""
    uppers = (ablation.start_at_level(level) for ablation in ablations for level in RIGID_LEVELS)
    return [deviation for upper in uppers for deviation in compute_deviations(upper)]


def select_largest(deviations: Iterable[Deviation], **place: str) -> list[Deviation]:
    """The deviations at their largest, of these arms, scenarios, orders, levels or quantities."""
    return [
        deviation
        for deviation in deviations
        if deviation.instant == "largest"
        and all(getattr(deviation, k) == v for k, v in place.items())
    ]


Span = tuple[float, float]


@dataclass(frozen=True)
class AblationVerdict:
    """The verdict on H2. fitting: levels that leave the paper's theta_2 in all readings.

    fitting and rest are under constant torque. rest: spans of each group's shares in what these
    levels leave; whole: in what the links' level leaves, in every scenario, order and reading;
    causes: what explains nearly all of that.
    """

    fitting: tuple[str, ...]
    rest: Mapping[str, Span]
    whole: Mapping[str, Span]
    causes: tuple[str, ...]

    @property
    def holds(self) -> bool | None:
        """Whether nearly all of what a fitting baseline leaves is reflected inertia."""
        return _nearly_all(self.rest[INERTIA][0])

    @property
    def holds_from_links(self) -> bool | None:
        """Whether nearly all of what the links and the payload alone leave is reflected inertia."""
        return _nearly_all(self.whole[INERTIA][0])

    @property
    def papers(self) -> bool | None:
        """Whether nearly all of either is the meshes' doing, as the paper has it."""
        return _nearly_all(max(self.most_meshes))

    @property
    def most_meshes(self) -> Span:
        """Largest share of all the meshes' effects in the rest, and in the whole."""
        rest, whole = (max(map(abs, spans[MESHES])) for spans in (self.rest, self.whole))
        return rest, whole

    @property
    def slips(self) -> Span:
        """Smallest and largest share of the printed matrices' errata in the rest."""
        return self.rest[SLIPPED]


@propagate_undefined
def _nearly_all(share: float) -> bool:
    return share >= NEARLY_ALL


def judge_ablation(
    levels: Sequence[Deviation], ablation_deviations: Sequence[Deviation], theta_2: Limits
) -> AblationVerdict:
    """The verdict on H2.

    levels: what baselines leave; ablation_deviations: whole; theta_2: the paper's.
    """
    angles = {
        level: select_largest(levels, scenario=TORQUE, level=level, quantity="theta_2")
        for level in RIGID_LEVELS
    }
    fitting = tuple(
        level
        for level, level_deviations in angles.items()
        if level_deviations and all(deviation.fits(theta_2) for deviation in level_deviations)
    )
    rest = [
        deviation
        for deviation in select_largest(levels, scenario=TORQUE)
        if deviation.level in fitting
    ]
    whole = [deviation for deviation in ablation_deviations if deviation.instant == "largest"]
    causes = tuple(dict.fromkeys(deviation.dominant for deviation in whole))
    return AblationVerdict(fitting, _spans(rest), _spans(whole), causes)


def _spans(deviations: Collection[Deviation]) -> dict[str, Span]:
    """The smallest and largest share of every group of levels."""
    shares = {group: [deviation.shares[group] for deviation in deviations] for group in GROUPS}
    return {
        group: (extreme_value(some, min), extreme_value(some, max))
        for group, some in shares.items()
    }


@dataclass(frozen=True)
class RigidResidual:
    """A rigid baseline's largest deviations under constant torque, by quantity.

    fits: whether that is what the paper says.
    """

    arm: str
    level: str
    deviations: Mapping[str, Deviation]
    fits: Mapping[str, bool]

    @property
    def id(self) -> str:
        """The id of the record in claims.json."""
        return f"ladder/baseline/{self.arm}/{self.level}"

    def span(self, group: str) -> Span:
        """Smallest and largest share of a group in the three deviations."""
        return _spans(self.deviations.values())[group]


def compute_residuals(
    levels: Iterable[Deviation], claims: Mapping[str, Claim]
) -> list[RigidResidual]:
    """What every rigid baseline leaves, by reading and level. claims: by quantity."""
    by_place: dict[tuple[str, str], dict[str, Deviation]] = {}
    for deviation in select_largest(levels, scenario=TORQUE):
        by_place.setdefault((deviation.arm, deviation.level), {})[deviation.quantity] = deviation
    return [
        RigidResidual(
            *place,
            deviations,
            {name: deviation.fits(claims[name].limits) for name, deviation in deviations.items()},
        )
        for place, deviations in by_place.items()
    ]
