"""The statements of the paper's Section 3.2 on models that leave one of the gears' effects out."""

from __future__ import annotations

from crosscheck.audit.claims.quantities import difference, of, over, where
from crosscheck.audit.claims.rule import Claim
from crosscheck.audit.claims.statements.control import (
    EXISTS,
    GONE,
    LARGER,
    SECOND,
    SMALLER,
    THIRD,
    WITHOUT_ERROR,
    in_third,
)
from crosscheck.audit.experiments.experiments import CONSTANT_STIFFNESS, NO_BACKLASH
from crosscheck.audit.measures.thresholds import EVIDENT

WITHOUT_BACKLASH, CONSTANT = (of(one, "third") for one in (NO_BACKLASH, CONSTANT_STIFFNESS))

CLAIMS = (
    Claim(
        "3.2-35",
        14,
        "Without backlash the second fluctuation disappears.",
        over(of(NO_BACKLASH, "second"), SECOND),
        GONE,
    ),
    Claim(
        "3.2-36",
        14,
        "Without backlash the third fluctuation is amplified; with it, weakened.",
        in_third(over(WITHOUT_BACKLASH, THIRD)),
        LARGER,
    ),
    Claim(
        "3.2-39",
        14,
        "Without tooth error the third fluctuation vanishes.",
        where(THIRD, EVIDENT, over(WITHOUT_ERROR, THIRD)),
        GONE,
    ),
    Claim(
        "3.2-40",
        14,
        "With constant stiffness the first fluctuation occurs.",
        of(CONSTANT_STIFFNESS, "first"),
        EXISTS,
    ),
    Claim(
        "3.2-41",
        14,
        "With constant stiffness the second fluctuation occurs.",
        of(CONSTANT_STIFFNESS, "second"),
        EXISTS,
    ),
    Claim(
        "3.2-42",
        14,
        "With constant stiffness the third fluctuation occurs.",
        in_third(CONSTANT),
        EXISTS,
    ),
    Claim(
        "3.2-43",
        14,
        "With constant stiffness the third fluctuation is smaller.",
        in_third(over(CONSTANT, THIRD)),
        SMALLER,
    ),
    Claim(
        "3.2-44",
        14,
        "Tooth error is the main source of internal excitation.",
        difference(CONSTANT, WITHOUT_ERROR),
        EXISTS,
        reading="leaving it out costs more of the third fluctuation than constant stiffness does",
    ),
    Claim(
        "3.2-45",
        14,
        "Varying stiffness intensifies the fluctuation.",
        difference(THIRD, CONSTANT),
        EXISTS,
    ),
)

RETIRED = (
    ("3.2-46", "says again of tiny clearance and error what 3.2-31 says"),
    ("3.2-34", "the paper does not say what the first fluctuation does without backlash"),
    ("3.2-37", "the paper does not say what the first fluctuation does without tooth error"),
    ("3.2-38", "the paper does not say what the second fluctuation does without tooth error"),
)
