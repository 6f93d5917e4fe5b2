"""A model that raises, or gives no number, fails its check and stops nothing."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.findings import Finding
from crosscheck.models.interface import STATE_ABILITIES
from tests.faults.faults import SEED, STATES, Setup, probe_model, unharmed
from tests.judged import compare_states

PAIR = ("analytic:physical", "pinocchio:gears")


def _finding(quantity: str, order: tuple[str, ...], answer: object) -> Finding:
    broken = probe_model("pinocchio:gears", Setup())
    setattr(broken, quantity, answer)
    models = {"analytic:physical": unharmed("analytic:physical", Setup()), broken.name: broken}
    chosen = [models[name] for name in order]
    (finding,) = compare_states("broken", chosen, [quantity], STATES, SEED)
    return finding


@pytest.mark.parametrize("order", [PAIR, PAIR[::-1]], ids=["as the second", "as the first"])
@pytest.mark.parametrize("quantity", STATE_ABILITIES)
def test_a_raising_model_is_a_failed_check(quantity, order):
    def raising(*state: object) -> np.ndarray:
        raise ZeroDivisionError("no such luck")

    finding = _finding(quantity, order, raising)
    why = "pinocchio:gears: ZeroDivisionError: no such luck"
    assert (finding.verdict, finding.note) == ("failed", why)


@pytest.mark.parametrize("order", [PAIR, PAIR[::-1]], ids=["as the second", "as the first"])
@pytest.mark.parametrize("quantity", STATE_ABILITIES)
def test_a_model_without_a_number_is_a_failed_check(quantity, order):
    shape = (6, 6) if quantity == "mass_matrix" else (6,)
    finding = _finding(quantity, order, lambda *state: np.full(shape, np.nan))
    assert (finding.verdict, finding.measured) == ("failed", None)


@pytest.mark.parametrize("order", [PAIR, PAIR[::-1]], ids=["as the second", "as the first"])
@pytest.mark.parametrize("quantity", STATE_ABILITIES)
def test_a_model_of_another_size_is_a_failed_check(quantity, order):
    shape = (5, 5) if quantity == "mass_matrix" else (5,)
    finding = _finding(quantity, order, lambda *state: np.ones(shape))
    assert finding.verdict == "failed"


@pytest.mark.parametrize("order", [PAIR, PAIR[::-1]], ids=["as the second", "as the first"])
@pytest.mark.parametrize("quantity", STATE_ABILITIES)
def test_a_model_that_always_answers_zero_differs(quantity, order):
    shape = (6, 6) if quantity == "mass_matrix" else (6,)
    finding = _finding(quantity, order, lambda *state: np.zeros(shape))
    assert finding.verdict in ("differ", "failed")
