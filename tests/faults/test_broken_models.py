"""A model that raises, or gives no number, fails its check and stops nothing."""

from collections.abc import Callable

import numpy as np
import pytest

from crosscheck.models.interface import STATE_ABILITIES
from crosscheck.registry import build
from tests.faults.checks import SEED, STATES, experiment, unharmed
from tests.judged import compare_states

PAIR = ("analytic:physical", "pinocchio:gears")
PROBE = ("probe", "pd", ())


def raising(size: int) -> np.ndarray:
    raise ZeroDivisionError("no such luck")


def answer_of(value: float, more: int = 0) -> Callable[[int], np.ndarray]:
    """An array of one value, of so many coordinates more."""
    return lambda dimensions: np.full((6 + more,) * dimensions, value)


WRONG = {  # what a model answers by dimensions, and what the check may then say
    "raises": (raising, {"failed"}),
    "no number": (answer_of(np.nan), {"failed"}),
    "another size": (answer_of(1.0, more=-1), {"failed"}),
    "always zero": (answer_of(0.0), {"differ", "failed"}),
}


@pytest.mark.parametrize("order", [PAIR, PAIR[::-1]], ids=["as the second", "as the first"])
@pytest.mark.parametrize("quantity", STATE_ABILITIES)
@pytest.mark.parametrize("wrong", WRONG)
def test_a_model_that_answers_wrongly_fails_its_check(wrong, quantity, order):
    answer, verdicts = WRONG[wrong]
    broken = build("pinocchio:gears", *experiment(*PROBE))
    dimensions = 2 if quantity == "mass_matrix" else 1
    setattr(broken, quantity, lambda *state: answer(dimensions))
    models = {"analytic:physical": unharmed("analytic:physical", *PROBE), broken.name: broken}
    chosen = [models[name] for name in order]
    (finding,) = compare_states("broken", chosen, [quantity], STATES, SEED)
    assert finding.verdict in verdicts
    if wrong == "raises":
        assert finding.note == "pinocchio:gears: ZeroDivisionError: no such luck"
    if wrong == "no number":
        assert finding.measured is None
