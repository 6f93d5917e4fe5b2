"""Values at states become the waves that they are made of, and what none makes is seen."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.loading import load_arm
from crosscheck.trial.changes.arms.segments import (
    ReferenceTerms,
    TermKey,
    build_reference_terms,
    derive_bias,
)
from crosscheck.trial.changes.arms.waves import WaveBasis, list_keys, minimum_state_count
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.judge.entries import EntryPlace

PAPER, ABSOLUTE = load_arm("paper-labelled"), Coordinates(links="absolute")


def terms(arm: Arm, coordinates: Coordinates) -> ReferenceTerms:
    """Of an arm in coordinates."""
    return build_reference_terms(build_frame(coordinates, arm), arm, usual_switches(arm))


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.integers(1, 5))
def test_waves_come_back(seed, count):
    known, generator = terms(PAPER, ABSOLUTE), np.random.default_rng(seed)
    angles = generator.uniform(-3, 3, (minimum_state_count(known), known.joints))
    keys = list_keys(known, (), "mass_matrix")
    chosen = [keys[place] for place in generator.choice(len(keys), count, replace=False)]
    planted = dict(zip(chosen, generator.uniform(0.1, 10, count), strict=True))
    values = np.zeros(len(angles))
    for key, coefficient in planted.items():
        angle = angles @ np.array(key.wave)
        values += coefficient * (np.sin(angle) if key.function == "sin" else np.cos(angle))
    found = WaveBasis(keys, angles, {}).fit(values, float(np.abs(values).max()))
    assert found == pytest.approx(planted, rel=1e-11)


@pytest.mark.parametrize("noise", [1e-15, 3e-13, 1e-8])
def test_what_noise_makes_of_a_wave_is_no_other_wave(noise):
    known, generator = terms(PAPER, ABSOLUTE), np.random.default_rng(5)
    angles = generator.uniform(-3, 3, (minimum_state_count(known), known.joints))
    values = 2.5 * np.cos(angles @ (1, -1)) + noise * generator.standard_normal(len(angles))
    found = WaveBasis(list_keys(known, (), "mass_matrix"), angles, {}).fit(values, 2.5)
    assert found == {TermKey((1, -1)): pytest.approx(2.5, rel=10 * noise)}


def test_what_no_wave_makes_is_none():
    known, generator = terms(PAPER, ABSOLUTE), np.random.default_rng(0)
    angles = generator.uniform(-3, 3, (minimum_state_count(known), known.joints))
    basis = WaveBasis(list_keys(known, (), "mass_matrix"), angles, {})
    assert basis.fit(np.tan(angles[:, 1] / 3.5), 1.0) is None


@pytest.mark.usefixtures("usual_states")
@pytest.mark.parametrize("joints", [1, 4, 7])
def test_enough_states_for_any_arm(joints):
    from crosscheck.cli.files.template import example_arm

    known = terms(example_arm("long", joints), ABSOLUTE)
    angles = np.random.default_rng(0).uniform(-3, 3, (minimum_state_count(known), joints))
    basis = WaveBasis(list_keys(known, (), "mass_matrix"), angles, {})
    assert np.linalg.cond(basis.table) < 20


def test_a_bias_follows_from_a_wrong_mass_matrix():
    """Of M = a cos(x_2), by hand: bias_1 = -a sin(x_2) v_2^2, and nothing of v_1 v_2."""
    key, places = TermKey((0, 1)), (EntryPlace("mass_matrix", *at) for at in ((0, 1), (1, 0)))
    made = derive_bias([(place, key, 3.0) for place in places], np.eye(2))
    of_row = {place.rates: value for (place, _), value in made.items() if place.row == 0}
    assert {rates: value for rates, value in of_row.items() if value} == {(1, 1): -3.0}
