"""Answers in another unit or order, just so near the right ones that this is said, and just not."""

from dataclasses import replace

import numpy as np
import pytest

from crosscheck.trial.arms.unit_mistakes import describe_unit_mistakes
from crosscheck.trial.input.equations import AnswerTable, Equations

RIGHT = np.append(np.full(79, 1.0), np.full(21, 2.0))[:, None]  # of one entry at 100 states
DEGREES = 57.29577951308232


def make_small(share: float) -> np.ndarray:
    """The same with 30 values that are such a part of the root mean square of all."""
    return np.append(np.full(70, np.sqrt(0.7)), np.full(30, 0.7 * share))[:, None]


def spoil(right: np.ndarray, states: int) -> np.ndarray:
    """Answers in mm, wrong at the last states."""
    wrong = 1000.0 * right
    wrong[len(right) - states :] *= 1.5
    return wrong


@pytest.mark.parametrize(
    ("user", "right", "times"),
    [
        (1000 * RIGHT, RIGHT, "1000"),
        (RIGHT / 1e6, RIGHT, "(1000)^-2"),
        (DEGREES * RIGHT, RIGHT, "180/pi"),
        (RIGHT / DEGREES**2, RIGHT, "(180/pi)^-2"),
        (1019.6 * RIGHT, RIGHT, "1000"),
        (1020.4 * RIGHT, RIGHT, None),
        (spoil(RIGHT, 19), RIGHT, "1000"),
        (spoil(RIGHT, 21), RIGHT, None),
        (spoil(make_small(0.98e-3), 30), make_small(0.98e-3), "1000"),
        (spoil(make_small(1.02e-3), 30), make_small(1.02e-3), None),
    ],
)
def test_a_factor_is_a_unit_at_four_fifths_of_the_states(user, right, times):
    lines = list(describe_unit_mistakes({"force": user}, {"force": right}, None, ["q"]))
    assert [line.split(" times")[0] for line in lines] == [f"force[q]: {times}"] * bool(times)


@pytest.mark.parametrize(("part", "count"), [(0.98, 1), (1.02, 0)])
def test_numbers_that_fit_in_another_order_are_in_that_order(part, count):
    right = np.random.default_rng(1).normal(size=(6, 2))
    off = right + part * 1e-6 * np.sqrt((right**2).mean())
    written = off.ravel(order="F").reshape(6, 2)
    table = AnswerTable(Equations(), values={"force": written}, at={"force": np.arange(6)})
    lines = list(describe_unit_mistakes({"force": written}, {"force": right}, table, ["q", "x"]))
    assert ["flattened the other way?" in line for line in lines] == [True] * count
    plain = replace(table, values={"force": right})
    assert not [*describe_unit_mistakes({"force": right}, {"force": right}, plain, ["q", "x"])]
