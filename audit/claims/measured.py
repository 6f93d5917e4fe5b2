"""What the experiments measure: every number once, and quantities of families of experiments.

Accelerations are the detailed arm's less those of the rigid arm at level `coupled`; mesh quantities
are those of the shoulder's sun-planet pair, first planet. The words are in ``measured.toml``, the
measures in ``experiments.pd`` (``transient`` and ``whole``), ``experiments.torque``
(``measure_constant_torque``, ``measure_back_and_forth``) and ``statics``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from crosscheck.audit.experiments import experiments as run
from crosscheck.audit.experiments.torque import ERROR_WINDOWS_S
from crosscheck.audit.judging import quantities as q
from crosscheck.audit.judging.quantities import ConditionResults, Measures, Number, Quantity
from crosscheck.audit.measures.thresholds import DOUBLED
from crosscheck.audit.statics.statics import BASE_MASSES, BENDS
from crosscheck.audit.statics.teeth import CONTACT_RATIOS, COUNTED, SIGMAS
from crosscheck.models.files import read_toml
from crosscheck.registry import RIGID_LEVELS

# By table of the file: what its names and words stand for, case by case.
CASES: dict[str, Sequence[Mapping[str, object]]] = {
    "pd": [{}],
    "constant_torque": [{}],
    "swings": [{"ends": n, "begin": b, "end": e} for n, (b, e) in ERROR_WINDOWS_S.items()],
    "static": [{}],
    "conversions": [{"how": how} for how in COUNTED],
    "bends": [{"angle": angle} for angle in BENDS],
    "sharpnesses": [{"sigma": sigma} for sigma in SIGMAS],
    "bases": [{"mass": mass} for mass in BASE_MASSES],
    "spectra": [{"joint": "", "name": "shoulder"}, {"joint": "_elbow", "name": "elbow"}],
    "positions": [{"joint": 1, "name": "shoulder"}, {"joint": 2, "name": "elbow"}],
    "levels": [{"level": level} for level in RIGID_LEVELS],
    "series": [{"ratio": ratio} for ratio in CONTACT_RATIOS],
}
_TABLES = read_toml(Path(__file__).with_suffix(".toml"))
WINDOWS: dict[str, str] = _TABLES["windows"]
MEASURED: dict[str, Number] = {
    name.format(**case): Number(*(text.format(**WINDOWS, **case) for text in number))
    for table, cases in CASES.items()
    for case in cases
    for name, number in _TABLES[table].items()
}
MEASURES = Measures(MEASURED)
SMALL_UM = 5.0
# By the run's length: ends of the 0.2 s in which errors are measured [s].
_FIRST_ENDS = ("0.4", "0.6", "0.8", "1")
ENDS = {"1": _FIRST_ENDS, "2": (*_FIRST_ENDS, "1.2", "1.4", "1.6", "1.8", "2")}
_FORCES, _DECAYS = ("second_force_N", "third_force_N"), ("first_decay_s", "second_decay_s")


def accumulation(kind: str, seconds: str, less: float | None = None) -> Quantity:
    """Smallest growth of an error [rad] from one 0.2 s to the next, up to so many seconds.

    Of the default backlash, less that of another size [um] if one is named.
    """

    def find_errors(results: ConditionResults, size_um: float) -> np.ndarray:
        member = run.SERIES[kind](size_um)
        return np.array([results[member][f"error_{end}_s"] for end in ENDS[seconds]])

    def formula(results: ConditionResults) -> np.ndarray:
        errors = find_errors(results, run.DEFAULT_B_UM)
        errors = errors if less is None else errors - find_errors(results, less)
        return np.min(errors[1:] / errors[:-1], axis=0)

    return Quantity(f"accumulation({kind}, {seconds} s, {less})", "1", formula)


def excess_accumulation(kind: str, seconds: str) -> Quantity:
    """The smaller of the error's accumulation and half its growth over the rigid arm's own."""
    member = run.SERIES[kind](run.DEFAULT_B_UM)
    error, rigid = (
        q.combine_quantities(
            "over",
            *(MEASURES.quantity_of(member, f"{whose}_{end}") for end in (f"{seconds}_s", "early")),
        )
        for whose in ("error", "own")
    )
    growth = q.scale_quantity(1 / DOUBLED, "1", q.combine_quantities("over", error, rigid))
    return q.combine_quantities("min", accumulation(kind, seconds), growth)


def error_ranks(kind: str, seconds: str) -> Quantity:
    """The least of the errors' rank correlations with backlash, in every 0.2 s."""
    ranks = (MEASURES.rank(kind, f"error_{end}_s") for end in ENDS[seconds])
    return q.combine_quantities("min", *ranks)


def larger_along(
    kind: str, first: str, second: str, results: ConditionResults
) -> tuple[np.ndarray, np.ndarray]:
    """Sizes (members,) [um], and the larger or defined one of two numbers (members, starts)."""
    sizes, values = q.series_values(kind, first, results)
    return sizes, np.fmax(values, q.series_values(kind, second, results)[1])


def _find_edge_force(results: ConditionResults) -> np.ndarray:
    _, forces = larger_along("backlash", *_FORCES, results)
    return np.minimum(forces[0], forces[-1]) / forces.min(axis=0)


def _find_default_force(results: ConditionResults) -> np.ndarray:
    _, forces = larger_along("backlash", *_FORCES, results)
    return np.fmax(*(results[run.PD][name] for name in _FORCES)) / forces.min(axis=0)


def _find_decay_where_wider(results: ConditionResults) -> np.ndarray:
    sizes, decays = larger_along("backlash", *_DECAYS, results)
    _, by_error = larger_along("tooth error", *_DECAYS, results)
    return np.fmax(decays[sizes > run.DEFAULT_E_UM].max(axis=0), by_error.max(axis=0))


# By the names in statements.toml.
NAMED = {
    "edges": Quantity(
        "least of the edges over least(backlash: second_force_N, third_force_N)",
        "1",
        _find_edge_force,
    ),
    "default": Quantity(
        "default over least(backlash: second_force_N, third_force_N)", "1", _find_default_force
    ),
    "wider": Quantity(
        "greatest(backlash over E, tooth error: first_decay_s, second_decay_s)",
        "s",
        _find_decay_where_wider,
    ),
    "as_wide": Quantity(
        f"longer(backlash {SMALL_UM:g} um: first_decay_s, second_decay_s)",
        "s",
        lambda results: larger_along("backlash", *_DECAYS, results)[1][0],
    ),
    "with_backlash": Quantity(
        "rank(backlash: second, third)",
        "1",
        lambda results: q.rank_correlation(*larger_along("backlash", "third", "second", results)),
    ),
}
FUNCTIONS: Mapping[str, Callable[..., Quantity]] = {
    "accumulation": accumulation,
    "excess accumulation": excess_accumulation,
    "error ranks": error_ranks,
}
