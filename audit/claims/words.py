"""The claims on the page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from audit.claims.judged import Judged
from audit.claims.rule import FEW, MOST, Answer, Kind, Verdict, ends
from audit.claims.settings import Plan
from audit.claims.summary import laws_of, strips
from audit.experiments.cells import LAWS, Law
from audit.experiments.scale import Scale
from audit.measures.undefined import shown
from audit.page.text import text
from audit.page.words import LAW_NAMES, number

if TYPE_CHECKING:
    from audit.claims.chapter import Row

# What a reader looks for first: what is wrong, what hangs on chance, what on an unknown.
ORDER = (
    *(Kind.FAILS, Kind.BISTABLE, Kind.ONLY, Kind.DEPENDS),
    *(Kind.UNDEFINED, Kind.NOT_SIMULATED, Kind.HOLDS),
)
COLOURS = {
    Kind.HOLDS: "agree",
    Kind.FAILS: "differ",
    Kind.ONLY: "unresolved",
    Kind.DEPENDS: "unresolved",
    Kind.BISTABLE: "bistable",
}


def page(found: Sequence[Row], plan: Plan, scale: Scale) -> str:
    """The rule, the count of verdicts by section, and every claim's row."""
    sections = dict.fromkeys(row.judged.claim.section for row in found)
    counts = Counter((row.judged.claim.section, row.judged.verdict.kind) for row in found)
    kinds = [kind for kind in ORDER if any(counts[section, kind] for section in sections)]
    return text(
        "claims/chapter",
        rows={s: _sorted([r for r in found if r.judged.claim.section == s]) for s in sections},
        counts=counts,
        kinds=kinds,
        plan=plan,
        starts=scale.most_starts,
        few=FEW,
        most=MOST,
        most_no=ends(scale.most_starts)[0],
        least_yes=ends(scale.most_starts)[1],
        on_a_start=[r.judged.claim.id for r in found if r.judged.hangs_on_a_start],
        moved=[r.judged.claim.id for r in found if r.judged.moved_by_a_coarser_grid],
        differing=[(r.judged.claim.id, one) for r in found for one in r.variants if one.differs],
        colours=COLOURS,
        law_words=LAW_NAMES,
        laws=LAWS,
        laws_of=laws_of,
        strips=strips,
        verdict=verdict_words,
        turning=turning_words,
        seen=seen_words,
    )


def _sorted(found: Sequence[Row]) -> list[Row]:
    """Failures and what hangs on the start first; else in the paper's order."""
    return sorted(found, key=lambda row: ORDER.index(row.judged.verdict.kind))


def verdict_words(found: Verdict) -> str:
    """In words."""
    words = str(found.kind)
    if found.laws:
        words += f" {' and '.join(law_words(law) for law in found.laws)}"
    if found.depends_on:
        said = " on" if found.kind == Kind.DEPENDS else "; depends on"
        words += f"{said} {', '.join(found.depends_on)}"
    if found.silent:
        words += f"; undefined with {' and '.join(law_words(law) for law in found.silent)}"
    return words


def law_words(law: Law) -> str:
    """Of one of LAWS; both with omega_t are told apart by their ring rate."""
    return LAW_NAMES[law]


def value_words(answer: Answer) -> str:
    """Median and the outer quantiles, once where they are equal as printed."""
    found = answer.quantiles
    if found is None:
        return "undefined"
    low, middle, high = map(number, found)
    return middle if low == high else f"{middle} ({low} … {high})"


def share_words(answer: Answer) -> str:
    """How many of the starts, and how many have no say."""
    share = answer.share
    if share is None:
        return f"undefined in {answer.undefined} of {answer.starts}"
    left = f", {answer.undefined} undefined" if answer.undefined else ""
    return f"{share.yes} of {share.of}{left}"


def seen_words(answer: Answer) -> str:
    """What the starts gave, and how many support the claim; those without its event apart."""
    if answer.starts == 1:
        return value_words(answer)
    if answer.undefined == answer.starts:
        return "in no start"
    return f"{value_words(answer)}, {share_words(answer)}"


def turning_words(judged: Judged) -> str:
    """The limits at which the verdict would turn."""
    places = [at for pair in judged.turning for at in pair if at is not None]
    return "; ".join(shown(at) for at in sorted(places)) or "at none"
