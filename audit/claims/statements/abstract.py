"""The statements of the paper's summary and introduction."""

from __future__ import annotations

from audit.claims.quantities import (
    Quantity,
    difference,
    each,
    largest,
    of,
    over,
    smallest,
    where,
)
from audit.claims.rule import Claim, above, below
from audit.experiments.experiments import BACK, BACK_EVEN, NO_ERROR, PD, Family
from audit.measures.thresholds import DOUBLED, EVIDENT, HALVED, SEVERE, VISIBLE_SHARE

# What Section 4.1 leaves open of the run back and forth: its drive's argument and its length.
SHAKEN = {
    "sin(20 π √t), 1 s": (BACK, "error_1_s"),
    "sin(20 π √t), 2 s": (BACK, "error_2_s"),
    "sin(20 π t), 1 s": (BACK_EVEN, "error_1_s"),
    "sin(20 π t), 2 s": (BACK_EVEN, "error_2_s"),
}
SHAKEN_BY = "drive and duration"


def accumulated(drive: Family, late: str) -> Quantity:
    """The smaller of the error's growth and of its share that is due to backlash."""
    end = of(drive(50), late)
    return smallest(over(end, of(drive(50), "error_early")), over(end, of(drive(0), late)))


CLAIMS = (
    Claim(
        "Abstract-01",
        15,
        "Backlash makes positioning errors accumulate when the joints rotate back and forth.",
        each(list(SHAKEN), lambda how: accumulated(*SHAKEN[how])),
        above(DOUBLED, "both at least doubled"),
        SHAKEN_BY,
        "accumulates by backlash: at the end there is more than early, and more than without it",
    ),
    Claim(
        "Abstract-02",
        14,
        "Tooth error is the main cause of severe acceleration fluctuations.",
        difference(of(PD, "third"), of(NO_ERROR, "third")),
        above(SEVERE, "what vanishes with the tooth error is itself severe"),
    ),
    Claim(
        "Abstract-03",
        13,
        "Tooth error is the main cause of severe meshing force impacts.",
        where(
            of(PD, "third"),
            EVIDENT,
            over(of(NO_ERROR, "third_force_fast_N"), of(PD, "third_force_fast_N")),
        ),
        below(HALVED, "without the main cause less than half is left"),
    ),
    Claim(
        "Abstract-04",
        11,
        "The fluctuations make the torque unsteady.",
        largest(of(PD, "torque_fast_1"), of(PD, "torque_fast_2")),
        above(VISIBLE_SHARE, "a line's width in a plot of the torque"),
    ),
)
