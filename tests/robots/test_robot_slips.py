"""The benchmark of slips: its right texts are right, and a few of its slips are named."""

import pytest

from benchmarks.bench_trial import SLIPS, TEXTS, score_slip, try_text

FEW = {
    "link 2 turns with its own rate alone",
    "factor two of a Coriolis term forgotten",
    "sign of the centrifugal force on the cart",
    "no gyroscopic term",
    "Coriolis acceleration of the slide left out",
    "an axis that is no unit vector",
    "inertia not rotated",
}


@pytest.mark.parametrize("kind", TEXTS)
def test_a_text_without_slips_agrees(kind):
    assert try_text(kind).agrees


def test_nothing_misleading_of_a_massless_pole():
    """Without its mass the pole's balance holds whatever it does, which explains nothing."""
    slip = next(s for s in SLIPS if s.name.startswith("a uniform rod"))
    assert not [line for line in score_slip(slip).texts if "missing in acceleration" in line]


@pytest.mark.parametrize("slip", [s for s in SLIPS if s.name in FEW], ids=lambda s: s.name)
def test_a_slip_is_named(slip):
    score = score_slip(slip)
    assert score[:3] == (True, True, True), score.texts
