"""What decides the statements that no single number of `statements.toml` does, by their ids."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from crosscheck.audit.claims.measured import MEASURES, pd, static, torque
from crosscheck.audit.experiments import experiments as run
from crosscheck.audit.judging import quantities as q
from crosscheck.audit.judging.quantities import (
    Choices,
    ConditionResults,
    Quantity,
    difference,
    maximum,
    minimum,
    ratio,
    restrict_above,
)
from crosscheck.audit.measures.thresholds import DOUBLED, EVIDENT, SEVERE

SMALL_UM = 5.0
SUDDEN_S = 0.1  # two thirds of the time for which an impact's vibration is followed
_FAST = "third_force_fast_N"
measure, rank, rank_among = MEASURES.quantity_of, MEASURES.rank, MEASURES.rank_among
no_error, no_backlash, steady, wide, turning, torque_no_error, torque_square = (
    partial(measure, experiment)
    for experiment in (
        run.NO_ERROR,
        run.NO_BACKLASH,
        run.CONSTANT_STIFFNESS,
        run.WIDE,
        run.TURNING,
        run.CONSTANT_NO_ERROR,
        run.CONSTANT_SQUARE,
    )
)
at_small, at_large = (partial(measure, run.BACKLASH(b)) for b in (SMALL_UM, run.CHAOTIC_UM))
error_08, error_16, error_32, error_63 = (
    partial(measure, run.ERROR(e)) for e in (0.8, 1.6, 3.2, 6.3)
)

FIRST, SECOND, THIRD = (pd(name) for name in ("first", "second", "third"))
ANY_WITHOUT_ERROR = q.maximum_over_starts(no_error("third"))
OWED = difference(THIRD, ANY_WITHOUT_ERROR)  # to the tooth error: no start has it without
MOST, LEAST = (
    fold(run.BACKLASH, "third") for fold in (MEASURES.series_maximum, MEASURES.series_minimum)
)


def restrict_to_third(quantity: Quantity) -> Quantity:
    """The quantity where the tooth error makes a third fluctuation beyond the controller's own."""
    return restrict_above(OWED, EVIDENT, quantity)


def restrict_to_large(name: str) -> Quantity:
    """A number at b = 1000 um where there is a third fluctuation."""
    return restrict_above(at_large("third"), EVIDENT, at_large(name))


def restrict_to_largest_error(quantity: Quantity) -> Quantity:
    """The quantity where the largest tooth error makes a third fluctuation."""
    return restrict_above(difference(error_63("third"), ANY_WITHOUT_ERROR), EVIDENT, quantity)


def find_factor(first: Quantity, second: Quantity) -> Quantity:
    """The larger over the smaller of two quantities."""
    return maximum(ratio(first, second), ratio(second, first))


def relative_change(waves: Quantity, sine: Quantity) -> Quantity:
    """The change of a number by the stiffness's harmonics, over the number's size."""
    return ratio(q.magnitude(difference(waves, sine)), q.magnitude(sine))


# By the run's length: ends of the 0.2 s in which errors are measured [s].
_FIRST_ENDS = ("0.4", "0.6", "0.8", "1")
ENDS = {"1": _FIRST_ENDS, "2": (*_FIRST_ENDS, "1.2", "1.4", "1.6", "1.8", "2")}


def list_drive_choices(quantity: Callable[[run.ExperimentSeries, str], Quantity]) -> Choices:
    """A quantity for both arguments of Fig. 15's drive, each for runs of 1 and 2 s."""
    drives = {"sin(20π√t)": run.BACK, "sin(20πt)": run.BACK_EVEN}
    return {f"{words}, {s} s": quantity(drives[words], s) for words in drives for s in ENDS}


def accumulation(series: run.ExperimentSeries, seconds: str, less: float | None = None) -> Quantity:
    """Smallest growth of an error [rad] from one 0.2 s to the next, up to so many seconds.

    Of the default backlash, less that of another size [um] if one is named.
    """

    def find_errors(results: ConditionResults, size_um: float) -> np.ndarray:
        return np.array([results[series(size_um)][f"error_{end}_s"] for end in ENDS[seconds]])

    def formula(results: ConditionResults) -> np.ndarray:
        errors = find_errors(results, run.DEFAULT_B_UM)
        errors = errors if less is None else errors - find_errors(results, less)
        return np.min(errors[1:] / errors[:-1], axis=0)

    return Quantity(f"accumulation({series.kind}, {seconds} s, {less})", "1", formula)


def self_accumulation(series: run.ExperimentSeries, seconds: str) -> Quantity:
    """The smaller of the error's accumulation and half its growth over the rigid arm's own."""
    error, rigid = (
        ratio(
            *(
                measure(series(run.DEFAULT_B_UM), f"{kind}_{when}")
                for when in (f"{seconds}_s", "early")
            )
        )
        for kind in ("error", "own")
    )
    return minimum(
        accumulation(series, seconds), q.scaled_quantity(ratio(error, rigid), 1 / DOUBLED, "1")
    )


def larger_along(
    series: run.ExperimentSeries, first: str, second: str, results: ConditionResults
) -> tuple[np.ndarray, np.ndarray]:
    """Sizes (members,) [um], and the larger or defined one of two numbers (members, starts)."""
    sizes, values = q.series_values(series, first, results)
    return sizes, np.fmax(values, q.series_values(series, second, results)[1])


_FORCES, _DECAYS = ("second_force_N", "third_force_N"), ("first_decay_s", "second_decay_s")


def _find_edge_force(results: ConditionResults) -> np.ndarray:
    _, forces = larger_along(run.BACKLASH, *_FORCES, results)
    return np.minimum(forces[0], forces[-1]) / forces.min(axis=0)


def _find_default_force(results: ConditionResults) -> np.ndarray:
    _, forces = larger_along(run.BACKLASH, *_FORCES, results)
    return np.fmax(*(results[run.PD][name] for name in _FORCES)) / forces.min(axis=0)


def _find_decay_where_wider(results: ConditionResults) -> np.ndarray:
    sizes, decays = larger_along(run.BACKLASH, *_DECAYS, results)
    _, by_error = larger_along(run.ERROR, *_DECAYS, results)
    return np.fmax(decays[sizes > run.DEFAULT_E_UM].max(axis=0), by_error.max(axis=0))


EDGES = Quantity(
    "least of the edges over least(backlash: second_force_N, third_force_N)",
    "1",
    _find_edge_force,
)
DEFAULT = Quantity(
    "default over least(backlash: second_force_N, third_force_N)",
    "1",
    _find_default_force,
)
WIDER = Quantity(
    "greatest(backlash over E, tooth error: first_decay_s, second_decay_s)",
    "s",
    _find_decay_where_wider,
)
AS_WIDE = Quantity(
    f"longer(backlash {SMALL_UM:g} um: first_decay_s, second_decay_s)",
    "s",
    lambda results: larger_along(run.BACKLASH, *_DECAYS, results)[1][0],
)
WITH_BACKLASH = Quantity(
    "rank(backlash: second, third)",
    "1",
    lambda results: q.rank_correlation(*larger_along(run.BACKLASH, "third", "second", results)),
)
AT_DEFAULT = maximum(*(pd(name) for name in _DECAYS))
OF_ERROR = ratio(no_error(_FAST), pd(_FAST))

QUANTITIES: Mapping[str, Quantity | Choices] = {
    # the model
    "2.1-03": minimum(
        ratio(no_error("third"), no_error("second")),
        ratio(no_error("third"), measure(run.BACKLASH_NO_ERROR(0.0), "third")),
    ),
    "2.1-04": {
        f"equal stiffness of {which}": ratio(SECOND, measure(experiment, "second"))
        for which, experiment in (
            ("all meshes together", run.TWO_PLANETS),
            ("each mesh", run.TWO_SOFTER),
        )
    },
    "2.1-05": find_factor(pd("after_start"), no_backlash("after_start")),
    "2.1-08": q.divergence(run.PD),
    "2.2-01": torque_no_error("stiffness_follows"),
    "2.2-02": difference(THIRD, steady("third")),
    **{
        name: relative_change(torque_square(number), torque(number))
        for name, number in (
            ("2.2-04", "x_ripple_um"),
            ("2.2-13", "theta_1_rad"),
            ("2.2-14", "others_ripple_N"),
        )
    },
    "2.2-11": maximum(static("contact_ratio_sp"), static("contact_ratio_pr")),
    "2.2-12": restrict_above(
        maximum(measure(run.SQUARE, "third"), THIRD),
        EVIDENT,
        find_factor(measure(run.SQUARE, "third"), THIRD),
    ),
    "2.3-01": ratio(torque("x_ripple_um"), torque_no_error("x_ripple_um")),
    # constant torque
    "3.1-07": ratio(torque("deviation_1_coupled_rad"), torque("deviation_1_links_rad")),
    "3.1-12": ratio(measure(run.CONSTANT_PRELOADED, "ringing_N"), torque("ringing_N")),
    "3.1-13": ratio(torque_no_error("x_ripple_um"), torque("x_ripple_um")),
    "3.1-18": measure(run.PLANTED, "planted_shown"),
    "3.1-19": {"the shoulder": torque("stroke_1"), "the elbow": torque("stroke_2")},
    # the motion under PD control
    "3.2-03": maximum(pd("final_1_rad"), pd("final_2_rad")),
    "3.2-47": maximum(pd("setback_1"), pd("overshoot_1")),
    "3.2-48": maximum(pd("setback_2"), pd("overshoot_2")),
    "3.2-11": maximum(SECOND, THIRD),
    "3.2-12": minimum(
        *(
            q.scaled_quantity(quantity, 1 / size, "1")
            for quantity, size in (
                (FIRST, EVIDENT),
                (pd("second_over_before"), DOUBLED),
                (THIRD, EVIDENT),
            )
        )
    ),
    "3.2-15": ratio(measure(run.PRELOADED, "first"), FIRST),
    "3.2-17": restrict_above(pd("second_over_before"), 1.0, pd("second_delay_s")),
    "3.2-19": q.scaled_quantity(pd("jump_um"), 1 / (2 * run.DEFAULT_B_UM), "2b"),
    "3.2-50": ratio(no_backlash("jump_um"), pd("jump_um")),
    "3.2-23": ratio(pd("fourth"), minimum(FIRST, SECOND, THIRD)),
    "3.2-24": AT_DEFAULT,
    "3.2-30": ratio(THIRD, maximum(FIRST, SECOND)),
    "3.2-31": maximum(SECOND, OWED),
    "3.2-35": ratio(no_backlash("second"), SECOND),
    "3.2-36": ratio(no_backlash("third"), THIRD),
    "3.2-39": restrict_above(THIRD, EVIDENT, ratio(no_error("third"), THIRD)),
    "3.2-40": ratio(steady("first"), FIRST),
    "3.2-41": ratio(steady("second"), SECOND),
    "3.2-42": steady("third"),
    "3.2-43": ratio(steady("third"), THIRD),
    "3.2-44": difference(steady("third"), no_error("third")),
    "3.2-45": difference(THIRD, steady("third")),
    # backlash
    "4-02": minimum(
        MEASURES.series_minimum(run.BACKLASH, "first"), measure(run.PRELOADED, "first")
    ),
    "4-03": MEASURES.fold_series("least of those with", run.BACKLASH, "second", np.fmin.reduce),
    "4.1-02": wide("deviation_rad"),
    "4.1-04": wide("gap_end_rad"),
    "4.1-05": list_drive_choices(accumulation),
    "4.1-06": list_drive_choices(
        lambda series, s: minimum(*(rank(series, f"error_{end}_s") for end in ENDS[s]))
    ),
    "4.1-07": list_drive_choices(self_accumulation),
    "4.1-28": ratio(turning("gap_end_rad"), turning("deviation_rad")),
    **{
        name: rank_among(run.BACKLASH, number, "side_change_s", 0.0)
        for name, number in (
            ("4.1-08", "second_force_N"),
            ("4.1-09", "side_change_s"),
            ("4.1-10", "bouncing_s"),
            ("4.1-11", "flight_s"),
        )
    },
    "4.1-12": ratio(MOST, LEAST),
    "4.1-13": ratio(at_small("third"), no_backlash("third")),
    "4.1-14": rank(run.BACKLASH, "third"),
    "4.1-15": rank(run.BACKLASH, _FAST),
    "4.1-16": at_small("side_changes"),
    "4.1-17": ratio(at_small("third"), THIRD),
    "4.1-18": restrict_above(MOST, SEVERE, ratio(LEAST, MOST)),
    "4.1-22": ratio(pd("line_elbow"), pd("line")),
    "4.1-31": ratio(measure(run.EXACT_ELBOW, "line_elbow"), pd("line_elbow")),
    "4.1-23": rank_among(run.BACKLASH, "frequency_Hz", "third", EVIDENT),
    "4.1-30": restrict_to_large("line_share"),
    "4.1-25": restrict_to_large("low_share"),
    "4.1-26": EDGES,
    "4.1-27": DEFAULT,
    # tooth error
    "4.2-01": error_63("deviation_rad"),
    "4.2-02": ratio(error_63("deviation_rad"), error_16("deviation_rad")),
    "4.2-04": WIDER,
    "4.2-17": q.restrict_below(AT_DEFAULT, SUDDEN_S, ratio(AS_WIDE, AT_DEFAULT)),
    "4.2-05": restrict_to_largest_error(ratio(error_63("third"), error_16("third"))),
    "4.2-06": error_08("third"),
    "4.2-07": error_16("third"),
    "4.2-08": restrict_to_largest_error(rank(run.ERROR, _FAST)),
    "4.2-09": minimum(error_16("static_over_line"), error_32("static_over_line")),
    "4.2-10": maximum(error_16("third"), error_32("third")),
    "4.2-11": maximum(error_16("static_over_line_elbow"), error_32("static_over_line_elbow")),
    "4.2-12": error_63("third"),
    "4.2-13": ratio(error_63("frequency_Hz"), pd("frequency_Hz")),
    "4.2-14": restrict_to_largest_error(ratio(error_63("third"), THIRD)),
    "4.2-15": restrict_above(THIRD, EVIDENT, OF_ERROR),
    "4.2-16": MEASURES.series_maximum(run.ERROR, "third"),
    # conclusion and abstract
    "5-02": ratio(no_backlash("second"), SECOND),
    "5-03": WITH_BACKLASH,
    "5-04": OWED,
    "5-05": difference(at_small("third"), THIRD),
    "5-06": restrict_to_largest_error(rank(run.ERROR, "third")),
    "Abstract-01": list_drive_choices(lambda series, s: accumulation(series, s, 0.0)),
    "Abstract-02": OWED,
    "Abstract-03": restrict_above(THIRD, EVIDENT, OF_ERROR),
    "Abstract-04": maximum(pd("torque_fast_1"), pd("torque_fast_2")),
}
