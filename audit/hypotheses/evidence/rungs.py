"""The ladder from a rigid arm to the paper's detailed one: one change of the model per rung.

A model is a set of features. Joint masses are taken away by setting them to zero in the arm's
data, so every order of rungs uses the project's own models; three features can stand on others
only: the coupling on the reflected inertia, the teeth's compliance on both, and play, stiffness
variation, tooth error, the paper's clock and its slips on the compliance.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.reading import angles
from crosscheck.audit.measures.rigid import rigid_model
from crosscheck.audit.measures.undefined import quotient
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


def variant(
    features: frozenset[str], scenario: str, arm: str, grid: tuple[float, int] = FINE
) -> Variant:
    """The simulation of a model with these features."""
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


def rungs(order: tuple[str, ...]) -> Iterator[frozenset[str]]:
    """The lowest model's features, then one more at each rung."""
    for count in range(len(order) + 1):
        yield frozenset(order[:count])


@dataclass(frozen=True)
class Ladder:
    """What every rung adds to detailed minus rigid.

    order: its name in ORDERS; level: the rigid one that it begins at; names: of its rungs, upwards;
    time (times,) [s]; fine, coarse (rungs, times, quantities) [rad, rad, m] at two steps.
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
        """Numerical uncertainty of every contribution (rungs, times, quantities)."""
        return SAFETY * np.abs(self.fine - self.coarse)

    @property
    def total(self) -> np.ndarray:
        """The whole deviation (times, quantities); the tip's is its magnitude [m]."""
        return self.fine.sum(axis=0)

    def largest(self, quantity: int) -> int:
        """Index of the time at which this deviation is largest."""
        return int(np.argmax(np.abs(self.total[:, quantity])))

    def above(self, level: str) -> Ladder:
        """What a baseline of this level leaves; in order A the levels are the lowest rungs."""
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


def climb(study: Study, scenario: str, arm: str, order: str, scale: Scale) -> Ladder:
    """Run a ladder at both steps. Raises Diverged."""
    chain = list(rungs(ORDERS[order]))
    fine, coarse = (
        [scale.cut(variant(one, scenario, arm, grid)) for one in chain] for grid in (FINE, COARSE)
    )
    runs = study.runs([*fine, *coarse], f"ladder {order}, {scenario}, {arm}", angles)
    geometry = fine[0].case().arm
    # theta_1, theta_2 [rad] and the tip's x, y [m], (times, 4).
    places = {
        one: np.hstack([run["theta"].values, tip_position(run, geometry).values])
        for one, run in runs.items()
    }
    parts = [contributions([places[one] for one in row]) for row in (fine, coarse)]
    time = runs[fine[0]]["time"].values
    return Ladder(scenario, arm, order, RIGID_LEVELS[0], ORDERS[order], time, *parts)


def contributions(places: list[np.ndarray]) -> np.ndarray:
    """What every rung adds, (rungs, times, 3), from places (times, 4) of each model in turn.

    The tip's steps are projected on the direction of the whole deviation, so that they too sum to
    the total.
    """
    steps = np.diff(np.array(places), axis=0)
    whole = places[-1][:, 2:] - places[0][:, 2:]
    distance = np.linalg.norm(whole, axis=1, keepdims=True)
    direction = np.divide(whole, distance, out=np.zeros_like(whole), where=distance > 0)
    towards = np.einsum("rta,ta->rt", steps[:, :, 2:], direction)
    return np.concatenate([steps[:, :, :2], towards[:, :, None]], axis=2)
