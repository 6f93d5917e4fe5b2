"""The damping fit: misfits of statements, and the measures behind them."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from crosscheck.paper.hypotheses import damping_fit
from crosscheck.paper.hypotheses.damping_fit import LARGEST_MISFIT, Statement

STATEMENT = Statement("a", "10 to 40", 10.0, 40.0, 1.25)


@pytest.mark.parametrize(
    ("measured", "misfit"),
    [(20.0, 0.0), (50.0, 1.0), (8.0, 1.0), (62.5, 2.0), (1e9, LARGEST_MISFIT),
     (None, LARGEST_MISFIT)],
)  # fmt: skip
def test_misfit(measured, misfit):
    assert STATEMENT.misfit(measured) == pytest.approx(misfit)


def test_explained_and_rms():
    assert damping_fit.explained([0.0, 0.99, 1.01]) == 2
    assert damping_fit.rms([3.0, 4.0]) == pytest.approx(np.sqrt(12.5))


def _run(x: np.ndarray, time: np.ndarray) -> xr.Dataset:
    return xr.Dataset({"x_sp": (("time", "joint", "planet"), x[:, None, None])}, {"time": time})


def test_torque_numbers_of_a_known_ripple():
    time = np.arange(0, 0.5, 1e-4)
    x = 52e-6 + 5e-6 * np.sin(2 * np.pi * 100 * time)
    numbers = damping_fit.torque_numbers(_run(x, time))
    assert numbers["middle_m"] == pytest.approx(52e-6)
    assert numbers["ripple_m"] == pytest.approx(1e-5)


def test_return_sees_through_chatter():
    time = np.arange(0, 2, 1e-3)
    x = np.where((time > 0.3) & (time < 1.5), -1.0, 1.0) + 1.5 * (-1.0) ** np.arange(time.size)
    assert damping_fit._return(time, x) == pytest.approx(1.5, abs=0.006)


def _fit(law: str, misfits: list[float]) -> dict:
    names = [statement.name for statement in damping_fit.STATEMENTS]
    return {
        "law": law,
        "zeta": 0.01,
        "misfits": dict(zip(names, misfits, strict=True)),
        "misfit": damping_fit.rms(misfits),
        "explained": damping_fit.explained(misfits),
    }


@pytest.mark.parametrize(
    ("last", "verdict"), [(0.9, "one ratio explains all"), (1.1, "no ratio explains all")]
)
def test_verdict_on_both_sides(last, verdict):
    fits = [_fit("one", [0.5] * 7 + [last]), _fit("other", [3.0] * 8)]
    assert damping_fit._verdict(fits)["verdict"] == verdict
