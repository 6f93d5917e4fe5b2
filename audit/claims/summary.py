"""What a claim's row shows: the settings of one model side by side, and what variants say."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

from crosscheck.audit.claims.judged import Judged
from crosscheck.audit.claims.rule import Answer, State, VerdictKind
from crosscheck.audit.experiments.cells import MODELS, READINGS, VARIANTS, GearModel

TYPICAL_ZETAS = (0.005, 0.05)  # of the figures, where the third fluctuation shows and where not


@dataclass(frozen=True)
class ClaimStrip:
    """A claim of one model, one choice of its free parameter and the readings that agree.

    model: of the gears, None where static; answers: by damping ratio, ascending.
    """

    model: GearModel | None
    readings: tuple[str, ...]
    choice: str
    answers: tuple[Answer, ...]

    @property
    def states(self) -> tuple[State, ...]:
        """By damping ratio."""
        return tuple(answer.state for answer in self.answers)

    @property
    def runs(self) -> list[tuple[State, tuple[float, ...]]]:
        """States with the neighbouring damping ratios that say so."""
        parts = groupby(self.answers, key=lambda answer: answer.state)
        return [
            (said, tuple(a.place.zeta for a in part if a.place.zeta is not None))
            for said, part in parts
        ]

    @property
    def typical(self) -> list[Answer]:
        """At TYPICAL_ZETAS; the one there is, where no damping enters."""
        return [a for a in self.answers if a.place.zeta in (None, *TYPICAL_ZETAS)]


def strips(judged: Judged, model: GearModel | None) -> list[ClaimStrip]:
    """Readings with the same states are told together, by the first one's numbers."""
    mine = [answer for answer in judged.answers if answer.place.model == model]
    by_states: dict[tuple[str, tuple[State, ...]], list[ClaimStrip]] = {}
    for (choice, arm), answers in _grouped(mine, lambda a: (a.place.choice, a.place.arm)).items():
        ordered = tuple(sorted(answers, key=lambda a: a.place.zeta or 0.0))
        strip = ClaimStrip(model, (READINGS[arm],), choice, ordered)
        by_states.setdefault((choice, strip.states), []).append(strip)
    return [
        ClaimStrip(model, tuple(s.readings[0] for s in alike), alike[0].choice, alike[0].answers)
        for alike in by_states.values()
    ]


def _grouped(
    answers: Sequence[Answer], key: Callable[[Answer], tuple[str, str]]
) -> dict[tuple[str, str], list[Answer]]:
    found: dict[tuple[str, str], list[Answer]] = {}
    for answer in answers:
        found.setdefault(key(answer), []).append(answer)
    return found


def models_of(judged: Judged) -> tuple[GearModel | None, ...]:
    """Those that the claim was asked of; none where it is static."""
    return (None,) if judged.claim.static else MODELS


@dataclass(frozen=True)
class Varied:
    """A claim asked of one of VARIANTS, beside what the model next to it says there."""

    model: GearModel
    kind: VerdictKind
    own: VerdictKind

    @property
    def differs(self) -> bool:
        """Whether the variant says something else."""
        return self.kind != self.own


def varied(judged: Judged, variants: Mapping[GearModel, Judged]) -> list[Varied]:
    """By every variant that has the claim's experiments."""
    return [
        Varied(model, other.verdict.kind, judged.by_model[VARIANTS[model]].kind)
        for model, other in variants.items()
        if other.answers and not judged.claim.static
    ]
