"""The statements of the paper's summary and introduction."""

from __future__ import annotations

from crosscheck.audit.claims.quantities import largest, of, over, where
from crosscheck.audit.claims.rule import Claim, above, below
from crosscheck.audit.claims.statements.control import OWED
from crosscheck.audit.claims.statements.section4 import ON_AND_ON, SWINGS, accumulation, swings
from crosscheck.audit.experiments.experiments import NO_ERROR, PD
from crosscheck.audit.measures.thresholds import EVIDENT, HALVED, SEVERE, VISIBLE_SHARE

CLAIMS = (
    Claim(
        "Abstract-01",
        15,
        "Backlash makes positioning errors accumulate when the joints rotate back and forth.",
        swings(lambda family, s: accumulation(family, s, "what b adds to the error", 0.0)),
        ON_AND_ON,
        SWINGS,
        "what b = 50 µm adds to the error without backlash grows on over the swings",
    ),
    Claim(
        "Abstract-02",
        14,
        "Tooth error is the main cause of severe acceleration fluctuations.",
        OWED,
        above(SEVERE, "what no start has without the tooth error is itself severe"),
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
