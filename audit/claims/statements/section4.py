"""What decides the statements of Sections 4 and 5 and of the abstract: backlash, tooth error."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crosscheck.audit.claims.measured import MEASURES, pd, static
from crosscheck.audit.claims.statements import section3
from crosscheck.audit.experiments import experiments as run
from crosscheck.audit.judging import quantities as q
from crosscheck.audit.judging.rule import (
    READ_OFF,
    ClaimCriteria,
    Limits,
    limits_above,
    limits_around,
    limits_below,
    limits_from_plot,
)
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

FALLS = limits_below(-CLEAR_RANK, "chance gives that in 2 of 100 where there are seven sizes")
RISES = limits_above(CLEAR_RANK, "chance gives that in 2 of 100 where there are seven sizes")
SEEN = limits_above(MINOR, "nothing smaller is seen in a plot of 300")
FREQUENCY = limits_from_plot(1500)

MOST, LEAST = (
    MEASURES.series_maximum(run.BACKLASH, "third"),
    MEASURES.series_minimum(run.BACKLASH, "third"),
)
AT_SMALL, NONE = (
    MEASURES.quantity_of(run.BACKLASH(SMALL), "third"),
    MEASURES.quantity_of(run.NO_BACKLASH, "third"),
)

_FIRST = ("0.4", "0.6", "0.8", "1")
# By the run's length: ends of the 0.2 s in which errors are measured [s].
ENDS = {"1": _FIRST, "2": (*_FIRST, "1.2", "1.4", "1.6", "1.8", "2")}
ON_AND_ON = limits_above(1.0, "it grows on from each 0.2 s to the next")
_DRIVES = {"sin(20π√t)": run.BACK, "sin(20πt)": run.BACK_EVEN}


def drive_choices(quantity: Callable[[run.ExperimentSeries, str], q.Quantity]) -> q.Choices:
    """A quantity for both arguments of Fig. 15's drive, each for runs of 1 and 2 s."""
    return {
        f"{words}, {seconds} s": quantity(series, seconds)
        for words, series in _DRIVES.items()
        for seconds in ("1", "2")
    }


def accumulation(
    series: run.ExperimentSeries, seconds: str, of_what: str, less: float | None
) -> q.Quantity:
    """Smallest growth of an error [rad] from one 0.2 s to the next, up to so many seconds.

    of_what: in words; of the default backlash, less that of another size [um] if one is named.
    """

    def errors(results: q.ConditionResults, size_um: float) -> np.ndarray:
        return np.array([results[series(size_um)][f"error_{end}_s"] for end in ENDS[seconds]])

    def formula(results: q.ConditionResults) -> np.ndarray:
        window_errors = errors(results, run.DEFAULT_B_UM) - (
            0.0 if less is None else errors(results, less)
        )
        return np.min(window_errors[1:] / window_errors[:-1], axis=0)

    return q.Quantity(
        f"accumulation({series.kind}, {seconds} s, {less})",
        f"smallest factor from one 0.2 s to the next of {of_what}",
        "1",
        formula,
        f"0.2 to {seconds} s",
    )


def least_rank_correlation(series: run.ExperimentSeries, seconds: str) -> q.Quantity:
    """The least rank correlation of the error with b in any 0.2 s up to so many seconds."""
    return q.minimum(*(MEASURES.rank(series, f"error_{end}_s") for end in ENDS[seconds]))


def growth(series: run.ExperimentSeries, kind: str, seconds: str) -> q.Quantity:
    """An error at the end over that from 0.1 to 0.3 s, with the default backlash."""
    experiment = series(run.DEFAULT_B_UM)
    return q.ratio(
        MEASURES.quantity_of(experiment, f"{kind}_{seconds}_s"),
        MEASURES.quantity_of(experiment, f"{kind}_early"),
    )


def self_accumulation(series: run.ExperimentSeries, seconds: str) -> q.Quantity:
    """The smaller of the error's accumulation and half its growth over the rigid arm's own."""
    growth_ratio = q.ratio(growth(series, "error", seconds), growth(series, "own", seconds))
    return q.minimum(
        accumulation(series, seconds, "the error", None),
        q.scaled_quantity(growth_ratio, 1 / DOUBLED, "1"),
    )


def maximum_along_series(
    series: run.ExperimentSeries, first_name: str, second_name: str, results: q.ConditionResults
) -> np.ndarray:
    """The larger of two numbers along a family, (members, starts); the defined one, if one is."""
    return np.fmax(
        q.series_values(series, first_name, results)[1],
        q.series_values(series, second_name, results)[1],
    )


def _worst_force(results: q.ConditionResults) -> np.ndarray:
    return maximum_along_series(run.BACKLASH, "second_force_N", "third_force_N", results)


def _number_at_large(name: str) -> q.Quantity:
    """A number at b = 1000 um, where there is a fluctuation."""
    return _restrict_to_large(MEASURES.quantity_of(run.BACKLASH(run.CHAOTIC_UM), name))


def _restrict_to_large(quantity: q.Quantity) -> q.Quantity:
    """The quantity where there is a third fluctuation at b = 1000 um too."""
    return section3.restrict_to_third(
        q.restrict_above(
            MEASURES.quantity_of(run.BACKLASH(run.CHAOTIC_UM), "third"), EVIDENT, quantity
        )
    )


_WORST = "largest mesh force of impact and third fluctuation"
EDGES = q.Quantity(
    "least of the edges over least(backlash: second_force_N, third_force_N)",
    f"{_WORST} at the better of the smallest and largest b over the least of all b",
    "1",
    lambda results: (
        np.minimum(_worst_force(results)[0], _worst_force(results)[-1])
        / _worst_force(results).min(axis=0)
    ),
)
DEFAULT = q.Quantity(
    "default over least(backlash: second_force_N, third_force_N)",
    f"{_WORST} at b = 50 µm over the least of all b",
    "1",
    lambda results: (
        np.fmax(results[run.PD]["second_force_N"], results[run.PD]["third_force_N"])
        / _worst_force(results).min(axis=0)
    ),
)
_AS_GOOD = "within 5 % one clearance is as good as another"

_FAST = "third_force_fast_N"
_BELOW_5 = (run.ERROR(1.6), run.ERROR(3.2))  # um, the sizes that the paper simulates
_AT_LARGEST, _AT_SMALLEST = (
    MEASURES.quantity_of(run.ERROR(6.3), "third"),
    MEASURES.quantity_of(run.ERROR(1.6), "third"),
)
_GROWS = limits_above(CLEAR_RANK, "chance gives that in 7 of 100 where there are five sizes")
_MINOR = Limits(MINOR, SEVERE, "more than nothing, and not severe")
_DRAMATIC = limits_above(DOUBLED, "a quarter more error, twice the fluctuation")


def _at_largest(quantity: q.Quantity) -> q.Quantity:
    """The quantity where the largest tooth error makes a third fluctuation."""
    return q.restrict_above(
        q.difference(_AT_LARGEST, section3.ANY_WITHOUT_ERROR), EVIDENT, quantity
    )


def _longest_decays(results: q.ConditionResults) -> tuple[np.ndarray, np.ndarray]:
    """b [um] (members,), and the longer decay of both impacts [s] (members, starts)."""
    sizes, _ = q.series_values(run.BACKLASH, "first_decay_s", results)
    return sizes, maximum_along_series(run.BACKLASH, "first_decay_s", "second_decay_s", results)


def _decay_where_wider(results: q.ConditionResults) -> np.ndarray:
    sizes, decays = _longest_decays(results)
    by_error = maximum_along_series(run.ERROR, "first_decay_s", "second_decay_s", results)
    return np.fmax(decays[sizes > run.DEFAULT_E_UM].max(axis=0), by_error.max(axis=0))


_DECAY = "longest time in which the impacts' fluctuations fall to a tenth"
WIDER = q.Quantity(
    "greatest(backlash over E, tooth error: first_decay_s, second_decay_s)",
    f"{_DECAY}, of all b and E with b larger than E",
    "s",
    _decay_where_wider,
)
_AT_DEFAULT = q.maximum(pd("first_decay_s"), pd("second_decay_s"))
AS_WIDE = q.restrict_below(
    _AT_DEFAULT,
    section3.SUDDEN_S,
    q.ratio(
        q.Quantity(
            f"longer(backlash {SMALL:g} um: first_decay_s, second_decay_s)",
            f"{_DECAY} at b = E",
            "s",
            lambda results: _longest_decays(results)[1][0],
        ),
        _AT_DEFAULT,
    ),
)
WITH_BACKLASH = q.Quantity(
    "rank(backlash: second, third)",
    "rank correlation with b of the larger of second and third fluctuation",
    "1",
    lambda results: q.rank_correlation(
        q.series_values(run.BACKLASH, "third", results)[0],
        maximum_along_series(run.BACKLASH, "second", "third", results),
    ),
)

DECIDED: ClaimCriteria = {
    # impacts
    "4-02": (
        q.minimum(
            MEASURES.series_minimum(run.BACKLASH, "first"),
            MEASURES.quantity_of(run.PRELOADED, "first"),
        ),
        SEEN,
    ),
    "4-03": (
        MEASURES.fold_series(
            "least of those with", "smallest", run.BACKLASH, "second", np.fmin.reduce
        ),
        SEEN,
    ),
    # position
    "4.1-01": (pd("deviation_rad"), section3.ON_SCALE),
    "4.1-02": (MEASURES.quantity_of(run.WIDE, "deviation_rad"), section3.ON_SCALE),
    "4.1-03": (
        static("tooth_thickness_share"),
        limits_around(1 / 3, 0.1, "nearly: a tenth of it"),
    ),
    "4.1-04": (
        MEASURES.quantity_of(run.WIDE, "gap_end_rad"),
        limits_below(1e-4, "a tenth of the scale that counts as negligible"),
    ),
    "4.1-05": (
        drive_choices(lambda family, s: accumulation(family, s, "the error", None)),
        ON_AND_ON,
    ),
    "4.1-06": (
        drive_choices(least_rank_correlation),
        limits_above(0.95, "all sizes in order; chance gives that in 1 of 720 where there are six"),
    ),
    "4.1-07": (
        drive_choices(self_accumulation),
        limits_above(1.0, "it grows on, and to twice what the rigid arm makes of any small error"),
    ),
    "4.1-28": (
        q.ratio(
            MEASURES.quantity_of(run.TURNING, "gap_end_rad"),
            MEASURES.quantity_of(run.TURNING, "deviation_rad"),
        ),
        limits_below(section3.VANISHED, "a tenth is left for the next swing"),
    ),
    # the size of an impact
    "4.1-08": (MEASURES.rank_among(run.BACKLASH, "second_force_N", "side_change_s", 0.0), RISES),
    "4.1-09": (MEASURES.rank_among(run.BACKLASH, "side_change_s", "side_change_s", 0.0), RISES),
    "4.1-10": (MEASURES.rank_among(run.BACKLASH, "bouncing_s", "side_change_s", 0.0), FALLS),
    "4.1-11": (MEASURES.rank_among(run.BACKLASH, "flight_s", "side_change_s", 0.0), RISES),
    # the fluctuation
    "4.1-12": (
        section3.restrict_to_third(MEASURES.spread(run.BACKLASH, "third")),
        limits_above(DOUBLED, "a change that no scatter explains"),
    ),
    "4.1-13": (
        section3.restrict_to_third(q.ratio(AT_SMALL, NONE)),
        Limits(0.5, 2.0, "alike to a factor of two"),
    ),
    "4.1-14": (section3.restrict_to_third(MEASURES.rank(run.BACKLASH, "third")), FALLS),
    "4.1-15": (
        section3.restrict_to_third(MEASURES.rank(run.BACKLASH, "third_force_fast_N")),
        FALLS,
    ),
    "4.1-16": (
        section3.restrict_to_third(MEASURES.quantity_of(run.BACKLASH(SMALL), "side_changes")),
        limits_above(70, "every 10 ms: one in fifteen periods of 1500 Hz"),
    ),
    "4.1-17": (section3.restrict_to_third(q.ratio(AT_SMALL, section3.THIRD)), section3.LARGER),
    "4.1-18": (
        section3.restrict_to_third(q.restrict_above(MOST, SEVERE, q.ratio(LEAST, MOST))),
        section3.GONE,
    ),
    # spectra
    "4.1-19": (section3.restrict_to_third(pd("frequency_Hz")), FREQUENCY),
    "4.1-20": (section3.restrict_to_third(pd("frequency_elbow_Hz")), FREQUENCY),
    "4.1-21": (
        section3.restrict_to_third(pd("overtones")),
        limits_above(1.5, "several are two at least"),
    ),
    "4.1-22": (
        section3.restrict_to_third(q.ratio(pd("line_elbow"), pd("line"))),
        limits_above(DOUBLED, "much: at least twice"),
    ),
    "4.1-31": (
        section3.restrict_to_third(
            q.ratio(MEASURES.quantity_of(run.EXACT_ELBOW, "line_elbow"), pd("line_elbow"))
        ),
        limits_above(HALVED, "most of it stays where the shoulder's teeth alone excite"),
    ),
    "4.1-23": (
        section3.restrict_to_third(
            MEASURES.rank_among(run.BACKLASH, "frequency_Hz", "third", EVIDENT)
        ),
        FALLS,
    ),
    "4.1-24": (
        _restrict_to_large(MEASURES.quantity_of(run.NEIGHBOURS, "lyapunov_per_s")),
        limits_above(23.0, "neighbouring motions part tenfold in every tenth of a second"),
    ),
    "4.1-30": (
        _number_at_large("line_share"),
        limits_below(0.2, "no line holds a fifth of the energy"),
    ),
    "4.1-29": (section3.restrict_to_third(pd("line_share")), section3.MOSTLY),
    "4.1-25": (_number_at_large("low_share"), section3.MOSTLY),
    "4.1-26": (EDGES, limits_above(1.05, _AS_GOOD)),
    "4.1-27": (DEFAULT, limits_below(1.05, _AS_GOOD)),
    # the size of the tooth error
    "4.2-01": (
        MEASURES.quantity_of(run.ERROR(6.3), "deviation_rad"),
        limits_below(1e-3, "the scale that Section 4.1 calls negligible"),
    ),
    "4.2-02": (
        q.ratio(
            MEASURES.quantity_of(run.ERROR(6.3), "deviation_rad"),
            MEASURES.quantity_of(run.ERROR(1.6), "deviation_rad"),
        ),
        limits_around(1.0, 0.1, "a tenth, while the error grows fourfold"),
    ),
    "4.2-03": (static("error_over_backlash"), Limits(0.05, 0.2, "a tenth, to a factor of two")),
    "4.2-04": (WIDER, section3.QUICKLY),
    "4.2-17": (
        AS_WIDE,
        limits_above(
            1.5, "half as long again: less is the moment at which a ringing passes its tenth"
        ),
    ),
    "4.2-05": (
        _at_largest(q.ratio(_AT_LARGEST, _AT_SMALLEST)),
        limits_above(DOUBLED, "a change that no scatter explains"),
    ),
    "4.2-06": (
        MEASURES.quantity_of(run.ERROR(0.8), "third"),
        limits_below(MINOR, "nothing that a plot of 300 would show"),
    ),
    "4.2-07": (_AT_SMALLEST, _MINOR),
    "4.2-08": (_at_largest(MEASURES.rank(run.ERROR, _FAST)), _GROWS),
    "4.2-09": (
        q.minimum(*(MEASURES.quantity_of(source, "static_over_line") for source in _BELOW_5)),
        section3.LARGER,
    ),
    "4.2-10": (q.maximum(*(MEASURES.quantity_of(source, "third") for source in _BELOW_5)), _MINOR),
    "4.2-11": (
        q.maximum(*(MEASURES.quantity_of(source, "static_over_line_elbow") for source in _BELOW_5)),
        section3.SMALLER,
    ),
    "4.2-12": (_AT_LARGEST, section3.SEVERELY),
    "4.2-13": (
        section3.restrict_to_third(
            q.ratio(MEASURES.quantity_of(run.ERROR(6.3), "frequency_Hz"), pd("frequency_Hz"))
        ),
        limits_around(1.0, READ_OFF, "basically the same: as well as a plot tells"),
    ),
    "4.2-14": (_at_largest(q.ratio(_AT_LARGEST, section3.THIRD)), _DRAMATIC),
    "4.2-15": (
        q.restrict_above(
            section3.THIRD, EVIDENT, q.ratio(MEASURES.quantity_of(run.NO_ERROR, _FAST), pd(_FAST))
        ),
        section3.GONE,
    ),
    "4.2-16": (MEASURES.series_maximum(run.ERROR, "third"), section3.SEVERELY),
    # the conclusion
    "5-01": (pd("after_start"), section3.EXISTS),
    "5-02": (
        q.ratio(MEASURES.quantity_of(run.NO_BACKLASH, "second"), section3.SECOND),
        limits_below(HALVED, "most of it is gone without backlash"),
    ),
    "5-03": (WITH_BACKLASH, RISES),
    "5-04": (section3.OWED, section3.EXISTS),
    "5-05": (section3.restrict_to_third(q.difference(AT_SMALL, section3.THIRD)), section3.EXISTS),
    "5-06": (_at_largest(MEASURES.rank(run.ERROR, "third")), _GROWS),
    # the abstract
    "Abstract-01": (
        drive_choices(lambda family, s: accumulation(family, s, "what b adds to the error", 0.0)),
        ON_AND_ON,
    ),
    "Abstract-02": (
        section3.OWED,
        limits_above(SEVERE, "what no start has without the tooth error is itself severe"),
    ),
    "Abstract-03": (
        q.restrict_above(
            pd("third"),
            EVIDENT,
            q.ratio(
                MEASURES.quantity_of(run.NO_ERROR, "third_force_fast_N"), pd("third_force_fast_N")
            ),
        ),
        limits_below(HALVED, "without the main cause less than half is left"),
    ),
    "Abstract-04": (
        q.maximum(pd("torque_fast_1"), pd("torque_fast_2")),
        limits_above(VISIBLE_SHARE, "a line's width in a plot of the torque"),
    ),
}
