"""What readers see for a phase law and a measured number."""

from __future__ import annotations

from crosscheck.audit.experiments.paper_conditions import (
    CONSERVATIVE,
    INTEGRAL,
    PRINTED,
    REPAIRED_RATE,
)

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
