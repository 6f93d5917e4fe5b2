"""The damping fit: misfits of statements, and the measures behind them."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.paper.claims.cells import RECORD_EVERY
from crosscheck.paper.hypotheses import damping_fit
from crosscheck.paper.hypotheses.damping_fit import (
    LARGEST_MISFIT,
    LAWS,
    Fit,
    FitVerdict,
    Law,
    Statement,
)
from crosscheck.studies.study import Variant

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


def test_the_fit_shares_the_claims_runs():
    plain = Variant(phase="omega_t", zeta=0.01, record_every=RECORD_EVERY)
    assert damping_fit._variant(Law("omega_t", "eq13"), 0.01).case() == plain.case()


def _fit(law: Law, misfits: list[float]) -> Fit:
    names = [statement.name for statement in damping_fit.STATEMENTS]
    return Fit(law, 0.01, dict.fromkeys(names), dict(zip(names, misfits, strict=True)))


@pytest.mark.parametrize(
    ("last", "verdict"), [(0.9, "one ratio explains all"), (1.1, "no ratio explains all")]
)
def test_verdict_on_both_sides(last, verdict):
    fits = (_fit(LAWS[0], [0.5] * 7 + [last]), _fit(LAWS[1], [3.0] * 8))
    assert FitVerdict(fits).verdict == verdict
