"""What decides the statements of Sections 4 and 5 and of the abstract: backlash, tooth error."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crosscheck.audit.claims import quantities as q
from crosscheck.audit.claims.rule import READ_OFF, Decided, Limits, about, above, below, read_off
from crosscheck.audit.claims.statements import section3
from crosscheck.audit.experiments import experiments as run
from crosscheck.audit.measures.thresholds import (
    DOUBLED,
    EVIDENT,
    HALVED,
    MINOR,
    SEVERE,
    VISIBLE_SHARE,
)

CLEAR_RANK = 0.75
SMALL = 5.0  # um

FALLS = below(-CLEAR_RANK, "chance gives that in 2 of 100 where there are seven sizes")
RISES = above(CLEAR_RANK, "chance gives that in 2 of 100 where there are seven sizes")
SEEN = above(MINOR, "nothing smaller is seen in a plot of 300")
FREQUENCY = read_off(1500)

MOST, LEAST = q.greatest(run.BACKLASH, "third"), q.least(run.BACKLASH, "third")
AT_SMALL, NONE = q.of(run.BACKLASH(SMALL), "third"), q.of(run.NO_BACKLASH, "third")

_FIRST = ("0.4", "0.6", "0.8", "1")
# By the run's length: ends of the 0.2 s in which errors are measured [s].
ENDS = {"1": _FIRST, "2": (*_FIRST, "1.2", "1.4", "1.6", "1.8", "2")}
ON_AND_ON = above(1.0, "it grows on from each 0.2 s to the next")
_DRIVES = {"sin(20π√t)": run.BACK, "sin(20πt)": run.BACK_EVEN}


def swings(quantity: Callable[[run.Family, str], q.Quantity]) -> q.Choices:
    """A quantity for both arguments of Fig. 15's drive, each for runs of 1 and 2 s."""
    return {
        f"{words}, {seconds} s": quantity(family, seconds)
        for words, family in _DRIVES.items()
        for seconds in ("1", "2")
    }


def accumulation(family: run.Family, seconds: str, of_what: str, less: float | None) -> q.Quantity:
    """Smallest growth of an error [rad] from one 0.2 s to the next, up to so many seconds.

    of_what: in words; of the default backlash, less that of another size [um] if one is named.
    """

    def errors(known: q.Known, size_um: float) -> np.ndarray:
        return np.array([known[family(size_um)][f"error_{end}_s"] for end in ENDS[seconds]])

    def formula(known: q.Known) -> np.ndarray:
        found = errors(known, run.DEFAULT_B_UM) - (0.0 if less is None else errors(known, less))
        return np.min(found[1:] / found[:-1], axis=0)

    return q.Quantity(
        f"accumulation({family.kind}, {seconds} s, {less})",
        f"smallest factor from one 0.2 s to the next of {of_what}",
        "1",
        formula,
        f"0.2 to {seconds} s",
    )


def in_order(family: run.Family, seconds: str) -> q.Quantity:
    """The least rank correlation of the error with b in any 0.2 s up to so many seconds."""
    return q.smallest(*(q.rank(family, f"error_{end}_s") for end in ENDS[seconds]))


def growth(family: run.Family, kind: str, seconds: str) -> q.Quantity:
    """An error at the end over that from 0.1 to 0.3 s, with the default backlash."""
    source = family(run.DEFAULT_B_UM)
    return q.over(q.of(source, f"{kind}_{seconds}_s"), q.of(source, f"{kind}_early"))


def itself(family: run.Family, seconds: str) -> q.Quantity:
    """The smaller of the error's accumulation and half its growth over the rigid arm's own."""
    own = q.over(growth(family, "error", seconds), growth(family, "own", seconds))
    return q.smallest(
        accumulation(family, seconds, "the error", None), q.times(own, 1 / DOUBLED, "1")
    )


def larger_of(family: run.Family, one: str, other: str, known: q.Known) -> np.ndarray:
    """The larger of two numbers along a family, (members, starts); the defined one, if one is."""
    return np.fmax(q.along(family, one, known)[1], q.along(family, other, known)[1])


def _worst(known: q.Known) -> np.ndarray:
    return larger_of(run.BACKLASH, "second_force_N", "third_force_N", known)


def _at_large(name: str) -> q.Quantity:
    """A number at b = 1000 um, where there is a fluctuation."""
    return _where_large(q.of(run.BACKLASH(run.CHAOTIC_UM), name))


def _where_large(quantity: q.Quantity) -> q.Quantity:
    """The quantity where there is a third fluctuation at b = 1000 um too."""
    return section3.in_third(
        q.where(q.of(run.BACKLASH(run.CHAOTIC_UM), "third"), EVIDENT, quantity)
    )


_WORST = "largest mesh force of impact and third fluctuation"
EDGES = q.Quantity(
    "least of the edges over least(backlash: second_force_N, third_force_N)",
    f"{_WORST} at the better of the smallest and largest b over the least of all b",
    "1",
    lambda known: np.minimum(_worst(known)[0], _worst(known)[-1]) / _worst(known).min(axis=0),
)
DEFAULT = q.Quantity(
    "default over least(backlash: second_force_N, third_force_N)",
    f"{_WORST} at b = 50 µm over the least of all b",
    "1",
    lambda known: (
        np.fmax(known[run.PD]["second_force_N"], known[run.PD]["third_force_N"])
        / _worst(known).min(axis=0)
    ),
)
_AS_GOOD = "within 5 % one clearance is as good as another"

_FAST = "third_force_fast_N"
_BELOW_5 = (run.ERROR(1.6), run.ERROR(3.2))  # um, the sizes that the paper simulates
_AT_LARGEST, _AT_SMALLEST = q.of(run.ERROR(6.3), "third"), q.of(run.ERROR(1.6), "third")
_GROWS = above(CLEAR_RANK, "chance gives that in 7 of 100 where there are five sizes")
_MINOR = Limits(MINOR, SEVERE, "more than nothing, and not severe")
_DRAMATIC = above(DOUBLED, "a quarter more error, twice the fluctuation")


def _at_largest(quantity: q.Quantity) -> q.Quantity:
    """The quantity where the largest tooth error makes a third fluctuation."""
    return q.where(q.difference(_AT_LARGEST, section3.ANY_WITHOUT_ERROR), EVIDENT, quantity)


def _decays(known: q.Known) -> tuple[np.ndarray, np.ndarray]:
    """b [um] (members,), and the longer decay of both impacts [s] (members, starts)."""
    sizes, _ = q.along(run.BACKLASH, "first_decay_s", known)
    return sizes, larger_of(run.BACKLASH, "first_decay_s", "second_decay_s", known)


def _where_wider(known: q.Known) -> np.ndarray:
    sizes, decays = _decays(known)
    by_error = larger_of(run.ERROR, "first_decay_s", "second_decay_s", known)
    return np.fmax(decays[sizes > run.DEFAULT_E_UM].max(axis=0), by_error.max(axis=0))


_DECAY = "longest time in which the impacts' fluctuations fall to a tenth"
WIDER = q.Quantity(
    "greatest(backlash over E, tooth error: first_decay_s, second_decay_s)",
    f"{_DECAY}, of all b and E with b larger than E",
    "s",
    _where_wider,
)
_AT_DEFAULT = q.largest(q.pd("first_decay_s"), q.pd("second_decay_s"))
AS_WIDE = q.where_below(
    _AT_DEFAULT,
    section3.SUDDEN_S,
    q.over(
        q.Quantity(
            f"longer(backlash {SMALL:g} um: first_decay_s, second_decay_s)",
            f"{_DECAY} at b = E",
            "s",
            lambda known: _decays(known)[1][0],
        ),
        _AT_DEFAULT,
    ),
)
WITH_BACKLASH = q.Quantity(
    "rank(backlash: second, third)",
    "rank correlation with b of the larger of second and third fluctuation",
    "1",
    lambda known: q.rank_correlation(
        q.along(run.BACKLASH, "third", known)[0], larger_of(run.BACKLASH, "second", "third", known)
    ),
)

DECIDED: Decided = {
    # impacts
    "4-02": (q.smallest(q.least(run.BACKLASH, "first"), q.of(run.PRELOADED, "first")), SEEN),
    "4-03": (
        q.over_family("least of those with", "smallest", run.BACKLASH, "second", np.fmin.reduce),
        SEEN,
    ),
    # position
    "4.1-01": (q.pd("deviation_rad"), section3.ON_SCALE),
    "4.1-02": (q.of(run.WIDE, "deviation_rad"), section3.ON_SCALE),
    "4.1-03": (q.static("tooth_thickness_share"), about(1 / 3, 0.1, "nearly: a tenth of it")),
    "4.1-04": (
        q.of(run.WIDE, "gap_end_rad"),
        below(1e-4, "a tenth of the scale that counts as negligible"),
    ),
    "4.1-05": (swings(lambda family, s: accumulation(family, s, "the error", None)), ON_AND_ON),
    "4.1-06": (
        swings(in_order),
        above(0.95, "all sizes in order; chance gives that in 1 of 720 where there are six"),
    ),
    "4.1-07": (
        swings(itself),
        above(1.0, "it grows on, and to twice what the rigid arm makes of any small error"),
    ),
    "4.1-28": (
        q.over(q.of(run.TURNING, "gap_end_rad"), q.of(run.TURNING, "deviation_rad")),
        below(section3.VANISHED, "a tenth is left for the next swing"),
    ),
    # the size of an impact
    "4.1-08": (q.rank_among(run.BACKLASH, "second_force_N", "side_change_s", 0.0), RISES),
    "4.1-09": (q.rank_among(run.BACKLASH, "side_change_s", "side_change_s", 0.0), RISES),
    "4.1-10": (q.rank_among(run.BACKLASH, "bouncing_s", "side_change_s", 0.0), FALLS),
    "4.1-11": (q.rank_among(run.BACKLASH, "flight_s", "side_change_s", 0.0), RISES),
    # the fluctuation
    "4.1-12": (
        section3.in_third(q.spread(run.BACKLASH, "third")),
        above(DOUBLED, "a change that no scatter explains"),
    ),
    "4.1-13": (
        section3.in_third(q.over(AT_SMALL, NONE)),
        Limits(0.5, 2.0, "alike to a factor of two"),
    ),
    "4.1-14": (section3.in_third(q.rank(run.BACKLASH, "third")), FALLS),
    "4.1-15": (section3.in_third(q.rank(run.BACKLASH, "third_force_fast_N")), FALLS),
    "4.1-16": (
        section3.in_third(q.of(run.BACKLASH(SMALL), "side_changes")),
        above(70, "every 10 ms: one in fifteen periods of 1500 Hz"),
    ),
    "4.1-17": (section3.in_third(q.over(AT_SMALL, section3.THIRD)), section3.LARGER),
    "4.1-18": (section3.in_third(q.where(MOST, SEVERE, q.over(LEAST, MOST))), section3.GONE),
    # spectra
    "4.1-19": (section3.in_third(q.pd("frequency_Hz")), FREQUENCY),
    "4.1-20": (section3.in_third(q.pd("frequency_elbow_Hz")), FREQUENCY),
    "4.1-21": (section3.in_third(q.pd("overtones")), above(1.5, "several are two at least")),
    "4.1-22": (
        section3.in_third(q.over(q.pd("line_elbow"), q.pd("line"))),
        above(DOUBLED, "much: at least twice"),
    ),
    "4.1-23": (
        section3.in_third(q.rank_among(run.BACKLASH, "frequency_Hz", "third", EVIDENT)),
        FALLS,
    ),
    "4.1-24": (
        _where_large(q.of(run.NEIGHBOURS, "lyapunov_per_s")),
        above(23.0, "neighbouring motions part tenfold in every tenth of a second"),
    ),
    "4.1-30": (_at_large("line_share"), below(0.2, "no line holds a fifth of the energy")),
    "4.1-29": (section3.in_third(q.pd("line_share")), section3.MOSTLY),
    "4.1-25": (_at_large("low_share"), section3.MOSTLY),
    "4.1-26": (EDGES, above(1.05, _AS_GOOD)),
    "4.1-27": (DEFAULT, below(1.05, _AS_GOOD)),
    # the size of the tooth error
    "4.2-01": (
        q.of(run.ERROR(6.3), "deviation_rad"),
        below(1e-3, "the scale that Section 4.1 calls negligible"),
    ),
    "4.2-02": (
        q.over(q.of(run.ERROR(6.3), "deviation_rad"), q.of(run.ERROR(1.6), "deviation_rad")),
        about(1.0, 0.1, "a tenth, while the error grows fourfold"),
    ),
    "4.2-03": (q.static("error_over_backlash"), Limits(0.05, 0.2, "a tenth, to a factor of two")),
    "4.2-04": (WIDER, section3.QUICKLY),
    "4.2-17": (
        AS_WIDE,
        above(1.5, "half as long again: less is the moment at which a ringing passes its tenth"),
    ),
    "4.2-05": (
        _at_largest(q.over(_AT_LARGEST, _AT_SMALLEST)),
        above(DOUBLED, "a change that no scatter explains"),
    ),
    "4.2-06": (
        q.of(run.ERROR(0.8), "third"),
        below(MINOR, "nothing that a plot of 300 would show"),
    ),
    "4.2-07": (_AT_SMALLEST, _MINOR),
    "4.2-08": (_at_largest(q.rank(run.ERROR, _FAST)), _GROWS),
    "4.2-09": (
        q.smallest(*(q.of(source, "static_over_line") for source in _BELOW_5)),
        section3.LARGER,
    ),
    "4.2-10": (q.largest(*(q.of(source, "third") for source in _BELOW_5)), _MINOR),
    "4.2-11": (
        q.largest(*(q.of(source, "static_over_line_elbow") for source in _BELOW_5)),
        section3.SMALLER,
    ),
    "4.2-12": (_AT_LARGEST, section3.SEVERELY),
    "4.2-13": (
        section3.in_third(q.over(q.of(run.ERROR(6.3), "frequency_Hz"), q.pd("frequency_Hz"))),
        about(1.0, READ_OFF, "basically the same: as well as a plot tells"),
    ),
    "4.2-14": (_at_largest(q.over(_AT_LARGEST, section3.THIRD)), _DRAMATIC),
    "4.2-15": (
        q.where(section3.THIRD, EVIDENT, q.over(q.of(run.NO_ERROR, _FAST), q.pd(_FAST))),
        section3.GONE,
    ),
    "4.2-16": (q.greatest(run.ERROR, "third"), section3.SEVERELY),
    # the conclusion
    "5-01": (q.pd("after_start"), section3.EXISTS),
    "5-02": (
        q.over(q.of(run.NO_BACKLASH, "second"), section3.SECOND),
        below(HALVED, "most of it is gone without backlash"),
    ),
    "5-03": (WITH_BACKLASH, RISES),
    "5-04": (section3.OWED, section3.EXISTS),
    "5-05": (section3.in_third(q.difference(AT_SMALL, section3.THIRD)), section3.EXISTS),
    "5-06": (_at_largest(q.rank(run.ERROR, "third")), _GROWS),
    # the abstract
    "Abstract-01": (
        swings(lambda family, s: accumulation(family, s, "what b adds to the error", 0.0)),
        ON_AND_ON,
    ),
    "Abstract-02": (
        section3.OWED,
        above(SEVERE, "what no start has without the tooth error is itself severe"),
    ),
    "Abstract-03": (
        q.where(
            q.pd("third"),
            EVIDENT,
            q.over(q.of(run.NO_ERROR, "third_force_fast_N"), q.pd("third_force_fast_N")),
        ),
        below(HALVED, "without the main cause less than half is left"),
    ),
    "Abstract-04": (
        q.largest(q.pd("torque_fast_1"), q.pd("torque_fast_2")),
        above(VISIBLE_SHARE, "a line's width in a plot of the torque"),
    ),
}
