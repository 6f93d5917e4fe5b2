"""What the ladder says: every deviation taken apart, and the verdicts of H2."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal, NamedTuple, get_args

import numpy as np

from crosscheck.audit.claims.rule import Claim, Limits
from crosscheck.audit.hypotheses.evidence.rungs import (
    GROUPS,
    INERTIA,
    MESHES,
    QUANTITIES,
    SLIPPED,
    Ladder,
)
from crosscheck.audit.measures.undefined import UNDEFINED, extreme, known, where_known
from crosscheck.registry import RIGID_LEVELS

# What Section 3.1 says of Fig. 6, each by the claim that judges it.
CLAIMS = {"theta_1": "3.1-01", "theta_2": "3.1-02", "tip": "3.1-04"}
IN_UNIT_OF_CLAIM = {"theta_1": 1.0, "theta_2": 1.0, "tip": 1e3}  # the tip's is in mm
TORQUE = "constant-torque"
NEARLY_ALL = 0.9  # of a deviation
Instant = Literal["end", "largest"]


class LevelPart(NamedTuple):
    """A rung's part of a deviation and its numerical uncertainty [rad or m]."""

    name: str
    contribution: float
    uncertainty: float


@dataclass(frozen=True)
class Deviation:
    """The detailed arm's from a rigid level at an instant, taken apart; shares by group of rungs.

    total [rad or m]; shares: nan if it is 0.
    """

    arm: str
    scenario: str
    order: str
    level: str
    quantity: str
    instant: Instant
    time_s: float
    total: float
    rungs: tuple[LevelPart, ...]
    shares: Mapping[str, float]

    @property
    def where(self) -> str:
        """Names what it is a deviation of."""
        return f"{self.arm}/{self.scenario}/{self.order}/{self.level}/{self.instant}"

    @property
    def dominant(self) -> str:
        """The group that alone explains nearly all of it, if one does."""
        if not known(*self.shares.values()):
            return UNDEFINED
        alone = [group for group, share in self.shares.items() if share >= NEARLY_ALL]
        return alone[0] if len(alone) == 1 else "none alone"

    def fits(self, limits: Limits) -> bool:
        """Whether its size is what the paper says."""
        size = abs(self.total) * IN_UNIT_OF_CLAIM[self.quantity]
        return bool(limits.yes(np.array([size]))[0])


def deviations(ladder: Ladder) -> list[Deviation]:
    """Of every quantity at the end and at its largest."""
    found = []
    for (number, quantity), instant in product(enumerate(QUANTITIES), get_args(Instant)):
        index = -1 if instant == "end" else ladder.largest(number)
        parts = [map(float, x[:, index, number]) for x in (ladder.fine, ladder.uncertainty)]
        one = Deviation(
            arm=ladder.arm,
            scenario=ladder.scenario,
            order=ladder.order,
            level=ladder.level,
            quantity=quantity,
            instant=instant,
            time_s=float(ladder.time[index]),
            total=float(ladder.total[index, number]),
            rungs=tuple(map(LevelPart, ladder.names, *parts)),
            shares=ladder.shares(index, number),
        )
        found.append(one)
    return found


def by_level(ladders: Iterable[Ladder]) -> list[Deviation]:
    """What every rigid baseline leaves, of ladders in order A."""
    uppers = (ladder.above(level) for ladder in ladders for level in RIGID_LEVELS)
    return [one for upper in uppers for one in deviations(upper)]


def largest(found: Iterable[Deviation], **place: str) -> list[Deviation]:
    """Those at their largest, of these arms, scenarios, orders, levels or quantities."""
    return [
        one
        for one in found
        if one.instant == "largest" and all(getattr(one, k) == v for k, v in place.items())
    ]


Span = tuple[float, float]


@dataclass(frozen=True)
class LadderVerdict:
    """H2. fitting: levels that leave the paper's theta_2 under constant torque, in all readings.

    rest: spans of each group's shares in what these leave; whole: in what the links' leave, in
    every scenario, order and reading; causes: what explains nearly all of that.
    """

    fitting: tuple[str, ...]
    rest: Mapping[str, Span]
    whole: Mapping[str, Span]
    causes: tuple[str, ...]

    @property
    def holds(self) -> bool | None:
        """Nearly all of what a fitting baseline leaves is reflected inertia."""
        return _nearly_all(self.rest[INERTIA][0])

    @property
    def holds_from_links(self) -> bool | None:
        """The same of what the links and the payload alone leave."""
        return _nearly_all(self.whole[INERTIA][0])

    @property
    def papers(self) -> bool | None:
        """The paper's own attribution, to the meshes, of either."""
        return _nearly_all(max(self.most_meshes))

    @property
    def most_meshes(self) -> Span:
        """Largest share of all effects of the meshes, of the rest and of the whole."""
        rest, whole = (max(map(abs, spans[MESHES])) for spans in (self.rest, self.whole))
        return rest, whole

    @property
    def slips(self) -> Span:
        """Share of the printed matrices' slips in the rest."""
        return self.rest[SLIPPED]


@where_known
def _nearly_all(share: float) -> bool:
    return share >= NEARLY_ALL


def ladder_verdict(
    levels: Sequence[Deviation], climbed: Sequence[Deviation], theta_2: Limits
) -> LadderVerdict:
    """levels: what every baseline leaves; climbed: of whole ladders; theta_2: the paper's."""
    angles = {
        level: largest(levels, scenario=TORQUE, level=level, quantity="theta_2")
        for level in RIGID_LEVELS
    }
    fitting = tuple(
        level for level, own in angles.items() if own and all(one.fits(theta_2) for one in own)
    )
    rest = [one for one in largest(levels, scenario=TORQUE) if one.level in fitting]
    whole = [one for one in climbed if one.instant == "largest"]
    causes = tuple(dict.fromkeys(one.dominant for one in whole))
    return LadderVerdict(fitting, _spans(rest), _spans(whole), causes)


def _spans(found: Sequence[Deviation]) -> dict[str, Span]:
    return {group: _span([one.shares[group] for one in found]) for group in GROUPS}


def _span(shares: Sequence[float]) -> Span:
    return extreme(shares, min), extreme(shares, max)


@dataclass(frozen=True)
class RigidResidual:
    """What a rigid baseline leaves under constant torque, at its largest, by quantity.

    fits: whether that is what the paper says.
    """

    arm: str
    level: str
    found: Mapping[str, Deviation]
    fits: Mapping[str, bool]

    @property
    def id(self) -> str:
        """Names it in claims.json."""
        return f"ladder/baseline/{self.arm}/{self.level}"

    def span(self, group: str) -> Span:
        """Of a group's shares in the three deviations."""
        return _span([one.shares[group] for one in self.found.values()])


def left(levels: Iterable[Deviation], claims: Mapping[str, Claim]) -> list[RigidResidual]:
    """By reading and level. claims: by quantity."""
    by_place: dict[tuple[str, str], dict[str, Deviation]] = {}
    for one in largest(levels, scenario=TORQUE):
        by_place.setdefault((one.arm, one.level), {})[one.quantity] = one
    return [
        RigidResidual(
            *place, found, {name: one.fits(claims[name].limits) for name, one in found.items()}
        )
        for place, found in by_place.items()
    ]
