"""The statements of the paper's Sections 4.2 and 5: the size of the tooth error; the conclusion."""

from __future__ import annotations

import numpy as np

from crosscheck.paper.claims.control import EXISTS, MINOR, POSITION_RAD
from crosscheck.paper.claims.quantities import BACKLASH, ERROR, NO_BACKLASH, NO_ERROR, PD, STATIC
from crosscheck.paper.claims.rule import (
    Claim,
    Known,
    Limits,
    about,
    above,
    along,
    below,
    difference,
    greatest,
    largest,
    of,
    over,
    rank,
    rank_correlation,
    ratio,
    where,
)
from crosscheck.paper.claims.section2 import DOUBLED, EVIDENT, HALVED, SEVERE
from crosscheck.paper.claims.section4 import SUPPRESSED, rises

ONE_ORDER = Limits(0.05, 0.2)
QUICKLY_S = 0.1


def overall(n: Known) -> float:
    """Rank of the largest fluctuation after the start with the backlash."""
    backlashes, second = along(BACKLASH, "second", n)
    return rank_correlation(backlashes, np.maximum(second, along(BACKLASH, "third", n)[1]))


TOOTH_ERROR = (
    Claim(
        "4.2",
        19,
        "The size of the tooth error hardly affects the positioning error.",
        "largest deviation from the rigid arm at 6.3 um",
        "rad",
        of(ERROR(6.3)("deviation_rad")),
        below(POSITION_RAD),
    ),
    Claim(
        "4.2",
        19,
        "The angular error is mostly unchanged when the tooth error grows.",
        "deviation at 6.3 um over that at 1.6 um",
        "1",
        ratio(ERROR(6.3)("deviation_rad"), ERROR(1.6)("deviation_rad")),
        about(1.0, 0.1),
    ),
    Claim(
        "4.2",
        None,
        "The tooth error is smaller than the backlash by one order of magnitude.",
        "E over b",
        "1",
        of(STATIC("error_over_backlash")),
        ONE_ORDER,
    ),
    Claim(
        "4.2",
        14,
        "Meshing and starting impacts converge rapidly while the backlash exceeds the error.",
        "longer of the times in which the first two fluctuations fall to a tenth",
        "s",
        largest(PD("first_decay_s"), PD("second_decay_s")),
        below(QUICKLY_S),
    ),
    Claim(
        "4.2",
        19,
        "The size of the error has a remarkable influence on the fluctuation.",
        "third fluctuation at 6.3 um over that at 1.6 um, where there is one",
        "1",
        where(ERROR(6.3)("third"), EXISTS, ratio(ERROR(6.3)("third"), ERROR(1.6)("third"))),
        above(DOUBLED),
    ),
    Claim(
        "4.2",
        19,
        "Below 1 um there is no fluctuation.",
        "third fluctuation at 0.8 um",
        "rad/s²",
        of(ERROR(0.8)("third")),
        below(MINOR),
    ),
    Claim(
        "4.2",
        19,
        "Minor fluctuations appear at 1.6 um.",
        "third fluctuation at 1.6 um",
        "rad/s²",
        of(ERROR(1.6)("third")),
        Limits(MINOR, SEVERE / 2),
    ),
    Claim(
        "4.2",
        19,
        "The contact force grows with the error.",
        "rank correlation of the fast mesh force with E, where there is a fluctuation",
        "1",
        where(ERROR(6.3)("third"), EXISTS, rank(ERROR, "third_force_fast_N")),
        rises,
    ),
    Claim(
        "4.2",
        20,
        "Below 5 um the shoulder's 0 Hz line dominates.",
        "0 Hz over the largest fast line at 3.2 um",
        "1",
        of(ERROR(3.2)("static_over_line")),
        above(1.0),
    ),
    Claim(
        "4.2",
        20,
        "Below 5 um the shoulder's fast components are a minor fluctuation.",
        "third fluctuation at 3.2 um",
        "rad/s²",
        of(ERROR(3.2)("third")),
        Limits(MINOR, SEVERE / 2),
    ),
    Claim(
        "4.2",
        20,
        "The elbow's fast components exceed its 0 Hz line.",
        "0 Hz over the largest fast line at 3.2 um",
        "1",
        of(ERROR(3.2)("static_over_line_elbow")),
        below(1.0),
    ),
    Claim(
        "4.2",
        20,
        "Above 5 um the self-excited fluctuation stands out.",
        "third fluctuation at 6.3 um",
        "rad/s²",
        of(ERROR(6.3)("third")),
        above(SEVERE),
    ),
    Claim(
        "4.2",
        20,
        "Its components are those of Fig. 18.",
        "frequency at 6.3 um over that at 5 um, where there is a fluctuation",
        "1",
        where(PD("third"), EXISTS, ratio(ERROR(6.3)("frequency_Hz"), PD("frequency_Hz"))),
        about(1.0, 0.1),
    ),
    Claim(
        "4.2",
        20,
        "From 5 to 6.3 um the magnitude grows dramatically.",
        "third fluctuation at 6.3 um over that at 5 um, where there is one",
        "1",
        where(ERROR(6.3)("third"), EXISTS, ratio(ERROR(6.3)("third"), PD("third"))),
        above(DOUBLED),
    ),
    Claim(
        "4.2",
        19,
        "Tooth error is the reason for the self-excited impacts.",
        "mesh force of the third fluctuation, without over with tooth error, where there is one",
        "1",
        where(PD("third"), EXISTS, ratio(NO_ERROR("third_force_fast_N"), PD("third_force_fast_N"))),
        below(SUPPRESSED),
    ),
    Claim(
        "4.2",
        19,
        "Tiny errors result in tremendous fluctuations.",
        "largest third fluctuation of all tooth errors",
        "rad/s²",
        greatest(ERROR, "third"),
        above(SEVERE),
    ),
)

CONCLUSION = (
    Claim(
        "5",
        14,
        "Gear meshing results in fluctuation.",
        "largest of the first three fluctuations",
        "rad/s²",
        largest(PD("first"), PD("second"), PD("third")),
        above(EVIDENT),
    ),
    Claim(
        "5",
        14,
        "Backlash is the cause of the excitation.",
        "largest of the first two fluctuations, without over with backlash",
        "1",
        over(
            largest(NO_BACKLASH("first"), NO_BACKLASH("second")),
            largest(PD("first"), PD("second")),
        ),
        below(HALVED),
    ),
    Claim(
        "5",
        16,
        "The fluctuation grows more severe with the backlash.",
        "rank correlation of the larger of second and third fluctuation with b",
        "1",
        overall,
        rises,
    ),
    Claim(
        "5",
        19,
        "Tooth error results in a self-excited fluctuation.",
        "part of the third fluctuation that vanishes with the tooth error",
        "rad/s²",
        difference(PD("third"), NO_ERROR("third")),
        above(EVIDENT),
    ),
    Claim(
        "5",
        17,
        "A small backlash intensifies it.",
        "third fluctuation at b = 5 um less that at 50 um",
        "rad/s²",
        difference(BACKLASH(5)("third"), PD("third")),
        above(EVIDENT),
    ),
    Claim(
        "5",
        19,
        "Tooth error must be kept as small as possible.",
        "rank correlation of the third fluctuation with E, where there is one",
        "1",
        where(ERROR(6.3)("third"), EXISTS, rank(ERROR, "third")),
        rises,
    ),
)

CLAIMS = (*TOOTH_ERROR, *CONCLUSION)
