"""What readers see for a phase law and a measured number."""

from __future__ import annotations

from crosscheck.audit.experiments.paper_conditions import (
    CONSERVATIVE,
    INTEGRAL,
    PRINTED,
    REPAIRED_RATE,
)
from crosscheck.audit.measures.undefined import UNDEFINED, float_or_none

LAW_NAMES = {
    PRINTED: "omega_t as printed",
    REPAIRED_RATE: "omega_t, ring repaired",
    INTEGRAL: "angle (integral)",
    CONSERVATIVE: "angle, springs push θ",
}
# Of figures, which draw the paper's own law in the paper's own model, and others with free planets.
DRAWN_NAMES = LAW_NAMES | {PRINTED: "as modelled in the paper", INTEGRAL: "as the gears are"}
LAW_MEANINGS = {
    PRINTED: "the paper's own law: present frequency times time",
    REPAIRED_RATE: "the same, the ring mesh's frequency put right",
    INTEGRAL: "the teeth that have passed",
}
ROUNDING = 1e-12  # below it a number that should be 0 says nothing but how its sum was ordered


def format_three_digits(value: float | None) -> str:
    """A number in three digits; in words where it is undefined, or nothing but rounding."""
    defined_value = float_or_none(value)
    if defined_value is None:
        return UNDEFINED
    return (
        "0 to rounding"
        if 0 < abs(defined_value) < ROUNDING
        else f"{float(f'{defined_value:.3g}'):g}"
    )
