"""What decides the statements of Sections 4.2 and 5 and of the abstract: the tooth error's size."""

from __future__ import annotations

import numpy as np

from crosscheck.audit.claims.quantities import (
    Known,
    Quantity,
    along,
    difference,
    greatest,
    largest,
    of,
    over,
    rank,
    rank_correlation,
    smallest,
    where,
    where_below,
)
from crosscheck.audit.claims.rule import READ_OFF, Decided, Limits, about, above, below
from crosscheck.audit.claims.statements.control import (
    ANY_WITHOUT_ERROR,
    EXISTS,
    GONE,
    LARGER,
    OWED,
    QUICKLY,
    SECOND,
    SEVERELY,
    SMALLER,
    SUDDEN_S,
    THIRD,
    in_third,
)
from crosscheck.audit.claims.statements.section4 import (
    AT_SMALL,
    CLEAR_RANK,
    ON_AND_ON,
    RISES,
    SMALL,
    accumulation,
    larger_of,
    swings,
)
from crosscheck.audit.experiments.experiments import (
    BACKLASH,
    DEFAULT_E_UM,
    ERROR,
    NO_BACKLASH,
    NO_ERROR,
    PD,
    STATIC,
)
from crosscheck.audit.measures.thresholds import (
    DOUBLED,
    EVIDENT,
    HALVED,
    MINOR,
    SEVERE,
    VISIBLE_SHARE,
)

_FAST = "third_force_fast_N"
_BELOW_5 = (ERROR(1.6), ERROR(3.2))  # um, the sizes that the paper simulates
_AT_LARGEST, _AT_SMALLEST = of(ERROR(6.3), "third"), of(ERROR(1.6), "third")
_GROWS = above(CLEAR_RANK, "chance gives that in 7 of 100 where there are five sizes")
_MINOR = Limits(MINOR, SEVERE, "more than nothing, and not severe")
_DRAMATIC = above(DOUBLED, "a quarter more error, twice the fluctuation")


def _at_largest(quantity: Quantity) -> Quantity:
    """Where the largest error makes a third fluctuation."""
    return where(difference(_AT_LARGEST, ANY_WITHOUT_ERROR), EVIDENT, quantity)


def _decays(known: Known) -> tuple[np.ndarray, np.ndarray]:
    """(b [um] (members,), longer decay of the impacts [s] (members, starts))."""
    sizes, _ = along(BACKLASH, "first_decay_s", known)
    return sizes, larger_of(BACKLASH, "first_decay_s", "second_decay_s", known)


def _where_wider(known: Known) -> np.ndarray:
    sizes, decays = _decays(known)
    by_error = larger_of(ERROR, "first_decay_s", "second_decay_s", known)
    return np.fmax(decays[sizes > DEFAULT_E_UM].max(axis=0), by_error.max(axis=0))


_DECAY = "longest time in which the impacts' fluctuations fall to a tenth"
WIDER = Quantity(
    "greatest(backlash over E, tooth error: first_decay_s, second_decay_s)",
    f"{_DECAY}, of all b and E with b larger than E",
    "s",
    _where_wider,
)
_AT_DEFAULT = largest(of(PD, "first_decay_s"), of(PD, "second_decay_s"))
AS_WIDE = where_below(
    _AT_DEFAULT,
    SUDDEN_S,
    over(
        Quantity(
            f"longer(backlash {SMALL:g} um: first_decay_s, second_decay_s)",
            f"{_DECAY} at b = E",
            "s",
            lambda known: _decays(known)[1][0],
        ),
        _AT_DEFAULT,
    ),
)
WITH_BACKLASH = Quantity(
    "rank(backlash: second, third)",
    "rank correlation with b of the larger of second and third fluctuation",
    "1",
    lambda known: rank_correlation(
        along(BACKLASH, "third", known)[0], larger_of(BACKLASH, "second", "third", known)
    ),
)

DECIDED: Decided = {
    # the size of the tooth error
    "4.2-01": (
        of(ERROR(6.3), "deviation_rad"),
        below(1e-3, "the scale that Section 4.1 calls negligible"),
    ),
    "4.2-02": (
        over(of(ERROR(6.3), "deviation_rad"), of(ERROR(1.6), "deviation_rad")),
        about(1.0, 0.1, "a tenth, while the error grows fourfold"),
    ),
    "4.2-03": (of(STATIC, "error_over_backlash"), Limits(0.05, 0.2, "a tenth, to a factor of two")),
    "4.2-04": (WIDER, QUICKLY),
    "4.2-17": (
        AS_WIDE,
        above(1.5, "half as long again: less is the moment at which a ringing passes its tenth"),
    ),
    "4.2-05": (
        _at_largest(over(_AT_LARGEST, _AT_SMALLEST)),
        above(DOUBLED, "a change that no scatter explains"),
    ),
    "4.2-06": (of(ERROR(0.8), "third"), below(MINOR, "nothing that a plot of 300 would show")),
    "4.2-07": (_AT_SMALLEST, _MINOR),
    "4.2-08": (_at_largest(rank(ERROR, _FAST)), _GROWS),
    "4.2-09": (smallest(*(of(source, "static_over_line") for source in _BELOW_5)), LARGER),
    "4.2-10": (largest(*(of(source, "third") for source in _BELOW_5)), _MINOR),
    "4.2-11": (largest(*(of(source, "static_over_line_elbow") for source in _BELOW_5)), SMALLER),
    "4.2-12": (_AT_LARGEST, SEVERELY),
    "4.2-13": (
        in_third(over(of(ERROR(6.3), "frequency_Hz"), of(PD, "frequency_Hz"))),
        about(1.0, READ_OFF, "basically the same: as well as a plot tells"),
    ),
    "4.2-14": (_at_largest(over(_AT_LARGEST, THIRD)), _DRAMATIC),
    "4.2-15": (where(THIRD, EVIDENT, over(of(NO_ERROR, _FAST), of(PD, _FAST))), GONE),
    "4.2-16": (greatest(ERROR, "third"), SEVERELY),
    # the conclusion
    "5-01": (of(PD, "after_start"), EXISTS),
    "5-02": (
        over(of(NO_BACKLASH, "second"), SECOND),
        below(HALVED, "most of it is gone without backlash"),
    ),
    "5-03": (WITH_BACKLASH, RISES),
    "5-04": (OWED, EXISTS),
    "5-05": (in_third(difference(AT_SMALL, THIRD)), EXISTS),
    "5-06": (_at_largest(rank(ERROR, "third")), _GROWS),
    # the abstract
    "Abstract-01": (
        swings(lambda family, s: accumulation(family, s, "what b adds to the error", 0.0)),
        ON_AND_ON,
    ),
    "Abstract-02": (
        OWED,
        above(SEVERE, "what no start has without the tooth error is itself severe"),
    ),
    "Abstract-03": (
        where(
            of(PD, "third"),
            EVIDENT,
            over(of(NO_ERROR, "third_force_fast_N"), of(PD, "third_force_fast_N")),
        ),
        below(HALVED, "without the main cause less than half is left"),
    ),
    "Abstract-04": (
        largest(of(PD, "torque_fast_1"), of(PD, "torque_fast_2")),
        above(VISIBLE_SHARE, "a line's width in a plot of the torque"),
    ),
}
