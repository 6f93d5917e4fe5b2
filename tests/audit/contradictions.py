"""What two places of a page say of one quantity in one setting, where both cannot be."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from itertools import permutations

from crosscheck.audit.errata.erratum import Erratum
from crosscheck.audit.judging.rule import State, VerdictKind
from tests.audit.stated import Said, Taught

HOLDING = (VerdictKind.HOLDS, VerdictKind.WHERE_DEFINED)


def contradictions(said: Iterable[Said]) -> list[str]:
    """Pairs with other states at the same limits, or narrower limits that hold where wider do not.

    A choice of a free parameter makes another quantity, so its name decides nothing.
    """
    groups: dict[tuple[object, ...], list[Said]] = defaultdict(list)
    for one in said:
        groups[one.quantity, *one.place._replace(choice="")].append(one)
    return sorted({text for group in groups.values() for text in _within(group)})


def held_and_denied(errata: Iterable[Erratum], kinds: Mapping[str, VerdictKind]) -> list[str]:
    """Claims that hold although the errata sheet says that they are wrong. kinds: by claim."""
    return [
        f"claim {claim} {kinds[claim]}, errata sheet: {erratum.id}"
        for erratum in errata
        for claim in erratum.denies
        if kinds.get(claim) in HOLDING
    ]


def taught_otherwise(findings: Iterable[Taught], kinds: Mapping[str, VerdictKind]) -> list[str]:
    """Findings that say yes to a claim that fails, or no to one that holds. kinds: by claim."""
    return [
        f"claim {one.claim} {kinds[one.claim]}, {one.where} says {one.is_true}"
        for one in findings
        if one.is_true is not None
        if kinds[one.claim] in ((VerdictKind.FAILS,) if one.is_true else HOLDING)
    ]


def _within(group: list[Said]) -> Iterator[str]:
    for one, other in permutations(group, 2):
        (low, high), (other_low, other_high) = ((x.limits.low, x.limits.high) for x in (one, other))
        if (low, high) == (other_low, other_high):
            if one.state != other.state:
                yield _told(*sorted((one, other), key=lambda said: (said.where, said.state)))
        elif other_low <= low and high <= other_high and not _possible(one.state, other.state):
            yield _told(one, other)


def _possible(narrow: State, wide: State) -> bool:
    """A share within wider limits is not smaller; what is undefined is so at any limits."""
    order = (State.NO, State.BISTABLE, State.YES)
    if State.UNDEFINED in (narrow, wide):
        return narrow == wide
    return order.index(narrow) <= order.index(wide)


def _told(one: Said, other: Said) -> str:
    return (
        f"{one.quantity} at {one.place}: {one.where} says {one.state} to {one.limits},"
        f" {other.where} says {other.state} to {other.limits}"
    )
