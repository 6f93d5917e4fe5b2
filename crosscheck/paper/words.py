"""What readers see for a phase law, a verdict and a measured number."""

from __future__ import annotations

from crosscheck.paper.cells import CONSERVATIVE, INTEGRAL, PRINTED, REPAIRED_RATE, Law
from crosscheck.paper.claims.rule import Answer, Kind, State, Verdict
from crosscheck.paper.numbers import defined

LAW_NAMES = {
    PRINTED: "ω t, as printed",
    REPAIRED_RATE: "ω t, ring rate repaired",
    INTEGRAL: "integral",
    CONSERVATIVE: "integral, springs push θ",
}
ROUNDING = 1e-12  # below it a number that should be 0 says nothing but how its sum was ordered
COLOURS = {State.YES: "agree", State.NO: "differ", State.BISTABLE: "unresolved"}
VERDICT_COLOURS = {Kind.HOLDS: "agree", Kind.FAILS: "differ", Kind.ONLY: "differ"}


def law_names(laws: tuple[Law, ...]) -> str:
    """In reading order."""
    return "; ".join(LAW_NAMES[law] for law in laws)


def verdict_words(verdict: Verdict) -> str:
    """With the laws that it holds with, and the parameters that decide."""
    words = str(verdict.kind)
    if verdict.laws:
        words += f" {law_names(verdict.laws)}"
    if verdict.depends_on:
        on = ", ".join(verdict.depends_on)
        words += f" on {on}" if verdict.kind == Kind.DEPENDS else f" ({on} decides)"
    return words


def number(value: float | None) -> str:
    """Three digits; said in words where it is undefined, or nothing but rounding."""
    known = defined(value)
    if known is None:
        return "undefined"
    return "0 to rounding" if 0 < abs(known) < ROUNDING else f"{float(f'{known:.3g}'):g}"


def spread(quantiles: tuple[float, ...] | None) -> str:
    """The median with the first and the last decile; one number where they are one."""
    if quantiles is None:
        return "undefined"
    low, middle, high = map(number, quantiles)
    return middle if low == high else f"{middle} ({low} … {high})"


def starts(answer: Answer) -> str:
    """How many of the starts support a claim, and for how many it is undefined."""
    share = answer.share
    said = "" if share is None else f"{share.yes} of {share.of} starts"
    if not answer.undefined:
        return said
    return f"{said}{', ' if said else ''}{answer.undefined} of {answer.starts} undefined"
