"""What the ladder says, record by record, and the verdicts of H2."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Literal

import numpy as np

from crosscheck.paper.hypotheses.ladder_rungs import GROUPS, ORDERS, QUANTITIES, Ladder
from crosscheck.paper.numbers import defined, finite, quotient
from crosscheck.paper.undefined import UNDEFINED, extreme, known, where_known, word
from crosscheck.registry import RIGID_LEVELS

# What Section 3.1 reads off Fig. 6, in the order of QUANTITIES [rad, rad, m].
PAPER = {"theta_1": 0.02, "theta_2": 0.01, "tip": 0.03}
NEARLY_ALL = 0.9  # of the whole deviation
SAME_SIZE = 2.0  # factor within which a value read off a figure counts as reproduced
MESHES, INERTIA, CARRIERS = "meshes", "reflected inertia", "joint masses and carriers"
Instant = Literal["end", "largest"]


@dataclass(frozen=True)
class Rung:
    """A rung's part of a deviation and its numerical uncertainty [rad or m]."""

    rung: str
    contribution: float
    uncertainty: float


@dataclass(frozen=True)
class Attribution:
    """A deviation at an instant, taken apart; shares by group of rungs, nan if it is 0."""

    arm: str
    scenario: str
    order: str
    quantity: str
    instant: Instant
    time_s: float
    total: float
    rungs: tuple[Rung, ...]
    shares: Mapping[str, float]

    @property
    def dominant(self) -> str:
        """What explains nearly all of it."""
        return dominant(self.shares)

    def to_dict(self) -> dict[str, object]:
        """For JSON; None for a share that is undefined."""
        place = f"{self.arm}/{self.scenario}/{self.order}/{self.quantity}/{self.instant}"
        return {
            "id": f"ladder/{place}",
            "arm": self.arm,
            "scenario": self.scenario,
            "order": self.order,
            "quantity": self.quantity,
            "instant": self.instant,
            "time_s": self.time_s,
            "unit": QUANTITIES[self.quantity],
            "total": self.total,
            "rungs": [asdict(rung) for rung in self.rungs],
            "shares": finite(self.shares),
            "dominant": self.dominant,
        }


def dominant(shares: Mapping[str, float]) -> str:
    """The group that alone explains nearly all of a deviation; else "none alone"."""
    if not known(*shares.values()):
        return UNDEFINED
    alone = [group for group, share in shares.items() if share >= NEARLY_ALL]
    return alone[0] if len(alone) == 1 else "none alone"


def order_name(ladder: Ladder) -> str:
    """By which name ORDERS has the ladder's order."""
    return next(name for name, order in ORDERS.items() if order == ladder.order)


def attributions(ladder: Ladder) -> list[Attribution]:
    """Of every quantity at the end and at its largest deviation."""
    instants: tuple[Instant, ...] = ("end", "largest")
    return [
        _attribution(ladder, number, quantity, instant)
        for number, quantity in enumerate(QUANTITIES)
        for instant in instants
    ]


def _attribution(ladder: Ladder, number: int, quantity: str, instant: Instant) -> Attribution:
    index = -1 if instant == "end" else ladder.largest(number)
    parts = ladder.fine[:, index, number], ladder.uncertainty[:, index, number]
    return Attribution(
        arm=ladder.arm,
        scenario=ladder.scenario,
        order=order_name(ladder),
        quantity=quantity,
        instant=instant,
        time_s=float(ladder.time[index]),
        total=float(ladder.total[index, number]),
        rungs=tuple(
            Rung(name, float(value), float(doubt))
            for name, value, doubt in zip(ladder.order, *parts, strict=True)
        ),
        shares=ladder.shares(index, number),
    )


@dataclass(frozen=True)
class LadderVerdict:
    """H2 as stated, from the carriers on, and the paper's attribution to the gear meshes.

    cause: what explains nearly all of every largest deviation; lowest, highest: share of each group
    in any deviation; rest: shares of the reflected inertia in what the carriers leave.
    """

    cause: str
    lowest: Mapping[str, float]
    highest: Mapping[str, float]
    rest: tuple[float, ...]

    @property
    def as_worded(self) -> str:
        """H2."""
        return self._whether(INERTIA)

    @property
    def papers(self) -> str:
        """The paper's attribution."""
        return self._whether(MESHES)

    @property
    def from_carriers(self) -> str:
        """H2 for a baseline that already has joint masses and carriers."""
        return word(_nearly_all(self.rest), "holds", "does not hold")

    @property
    def rest_span(self) -> tuple[float, float]:
        """The rest's lowest and highest."""
        return extreme(self.rest, min), extreme(self.rest, max)

    @property
    def largest_mesh_share(self) -> float:
        """Of any deviation, in magnitude."""
        return max(abs(self.lowest[MESHES]), abs(self.highest[MESHES]))

    def _whether(self, said: str) -> str:
        answer = None if self.cause == UNDEFINED else self.cause == said
        return word(answer, "holds", "does not hold")

    def to_dicts(self) -> list[dict[str, object]]:
        """For JSON: three verdicts."""
        low, high = self.rest_span
        return [
            {
                "id": "H2",
                "verdict": self.as_worded,
                "dominant": self.cause,
                "lowest_share": finite(self.lowest),
                "highest_share": finite(self.highest),
            },
            {
                "id": "H2/from-carriers",
                "verdict": self.from_carriers,
                "lowest_share": defined(low),
                "highest_share": defined(high),
            },
            {
                "id": "H2/paper",
                "verdict": self.papers,
                "largest_mesh_share": defined(self.largest_mesh_share),
            },
        ]


def ladder_verdict(found: Sequence[Attribution]) -> LadderVerdict:
    """From the largest deviations; from the carriers: order A, constant torque."""
    decisive = [one for one in found if one.instant == "largest"]
    first = [r for r in decisive if (r.order, r.scenario) == ("A", "constant-torque")]
    return LadderVerdict(
        _common({one.dominant for one in decisive}),
        {group: extreme((one.shares[group] for one in found), min) for group in GROUPS},
        {group: extreme((one.shares[group] for one in found), max) for group in GROUPS},
        tuple(quotient(r.shares[INERTIA], 1 - r.shares[CARRIERS]) for r in first),
    )


def _common(causes: set[str]) -> str:
    """The one cause; undefined if one is."""
    if UNDEFINED in causes:
        return UNDEFINED
    return causes.pop() if len(causes) == 1 else "none alone"


@where_known
def _nearly_all(shares: Sequence[float]) -> bool:
    return min(shares) >= NEARLY_ALL


@dataclass(frozen=True)
class Baseline:
    """The detailed arm's deviation at the end from a rigid level, by quantity [rad, rad, m]."""

    arm: str
    level: str
    deviation: Mapping[str, float]

    @property
    def reproduces(self) -> dict[str, bool]:
        """Which of the paper's magnitudes."""
        return {name: reproduces(self.deviation[name], PAPER[name]) for name in PAPER}

    @property
    def factor(self) -> float:
        """How far the worst of them is off."""
        return max(misfit_factor(self.deviation[name], PAPER[name]) for name in PAPER)

    @property
    def is_the_papers(self) -> bool:
        """Whether all are the paper's."""
        return all(self.reproduces.values())

    @property
    def name(self) -> str:
        """Arm and level."""
        return f"{self.arm}/{self.level}"

    @property
    def id(self) -> str:
        """Its name among the records."""
        return f"ladder/baseline/{self.name}"

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        return {
            "id": self.id,
            "deviation": dict(self.deviation),
            "reproduces": self.reproduces,
            "factor": self.factor,
            "verdict": "reproduces the paper" if self.is_the_papers else "does not",
        }


def baselines(ladder: Ladder) -> list[Baseline]:
    """The detailed arm against each rigid level.

    Order B ends with the joint masses: without that rung, neither side has them.
    """
    if ladder.order == ORDERS["A"]:
        remaining = np.cumsum(ladder.fine[::-1, -1], axis=0)[::-1]
        return [_baseline(ladder, *pair) for pair in zip(RIGID_LEVELS, remaining, strict=False)]
    massless = ladder.fine[:-1, -1].sum(axis=0)
    return [_baseline(ladder, "links, neither side with joint masses", massless)]


def _baseline(ladder: Ladder, level: str, deviation: np.ndarray) -> Baseline:
    values = dict(zip(QUANTITIES, map(float, deviation), strict=True))
    return Baseline(ladder.arm, level, values)


def reproduces(measured: float, stated: float) -> bool:
    """Whether a magnitude is the paper's, within the factor that a figure's reading allows."""
    return misfit_factor(measured, stated) <= SAME_SIZE


def misfit_factor(measured: float, stated: float) -> float:
    """How many times too large or too small a magnitude is, at least 1."""
    ratio = max(abs(measured), 1e-15) / stated
    return max(ratio, 1 / ratio)
