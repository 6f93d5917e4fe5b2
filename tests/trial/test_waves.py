"""Values at states become the waves and signals that they are made of, and what is left is said."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.loading import load_arm
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.diagnose.terms.force_variants import ForceDifferences
from crosscheck.trial.diagnose.terms.harmonic_fit import (
    HarmonicBasis,
    list_angle_sums,
    make_term_keys,
    minimum_state_count,
)
from crosscheck.trial.diagnose.terms.messages import describe_term_error
from crosscheck.trial.diagnose.terms.polynomial import TermKey
from crosscheck.trial.diagnose.terms.reference_terms import ForceStates
from crosscheck.trial.judge.entries import EntryPlace
from tests.trial.planted import ABSOLUTE, LUMPED, terms
from tests.trial.states import sample

UNLIKE, PAPER = load_arm("three-unlike"), load_arm("paper-labelled")


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.integers(1, 5))
def test_waves_come_back(seed, count):
    known, generator = terms(PAPER, ABSOLUTE), np.random.default_rng(seed)
    angles = generator.uniform(-3, 3, (minimum_state_count(known), known.joints))
    fitting = HarmonicBasis.from_angle_sums(known, angles)
    keys = make_term_keys(list_angle_sums(known))
    chosen = [keys[place] for place in generator.choice(len(keys), count, replace=False)]
    planted = dict(zip(chosen, generator.uniform(0.1, 10, count), strict=True))
    values = np.zeros(len(angles))
    for key, coefficient in planted.items():
        angle = angles @ np.array(key.wave)
        values += coefficient * (np.sin(angle) if key.function == "sin" else np.cos(angle))
    fit = fitting.fit(values, float(np.abs(values).max()), {})
    assert fit.significant_coefficients == pytest.approx(planted, rel=1e-11)
    assert fit.left_over == 0.0


def test_what_no_wave_makes_is_left_over():
    known, generator = terms(PAPER, ABSOLUTE), np.random.default_rng(0)
    angles = generator.uniform(-3, 3, (minimum_state_count(known), known.joints))
    fit = HarmonicBasis.from_angle_sums(known, angles).fit(np.tan(angles[:, 1] / 3.5), 1.0, {})
    assert fit.left_over > 1e-3


@pytest.mark.usefixtures("usual_states")
@pytest.mark.parametrize("joints", [1, 4, 7])
def test_enough_states_for_any_arm(joints):
    from crosscheck.cli.files.template import example_arm

    known = terms(example_arm("long", joints), ABSOLUTE)
    angles = np.random.default_rng(0).uniform(-3, 3, (minimum_state_count(known), joints))
    assert np.linalg.cond(HarmonicBasis.from_angle_sums(known, angles).table) < 20


def _forces(**chosen: str) -> tuple[ForceDifferences, np.ndarray]:
    """Of the paper's arm, with the force of these switches."""
    own = usual_switches(PAPER)
    right = sample(PAPER, "analytic:physical", LUMPED, own, 250, 5)
    q, v = right.x @ right.frame.matrix.T, right.v @ right.frame.matrix.T
    torque = np.array([right.signals["T_1"], right.signals["T_2"]]).T
    states = ForceStates(right.time, q, v, torque)
    differences = ForceDifferences(build_frame(LUMPED, PAPER), PAPER, own, states, right.v)
    yours = sample(PAPER, "analytic:physical", LUMPED, usual_switches(PAPER, **chosen), 250, 5)
    return differences, yours.force() - right.force()


@pytest.mark.parametrize(
    ("chosen", "expected"),
    [
        ({"ring_rate": "eq13"}, "ring_rate = eq13 where ring_rate = corrected belongs"),
        ({"phase": "omega_t", "ring_rate": "corrected"}, "phase = omega_t where phase = angle"),
    ],
)
def test_another_law_of_the_mesh_is_named(chosen, expected):
    differences, off = _forces(**chosen)
    place = EntryPlace("force", 1)  # x_pr1
    found = differences.explain(place, off[:, 1], 1e5)
    assert found is not None
    assert describe_term_error(found.errors[0]).startswith(expected)


def test_backlash_left_out_of_one_mesh_is_named():
    differences, off = _forces()
    mesh = PAPER.joints[0].ring_mesh.model_copy(update={"backlash_m": 0.0})
    joint = PAPER.joints[0].model_copy(update={"ring_mesh": mesh})
    arm = PAPER.model_copy(update={"joints": (joint, PAPER.joints[1])})
    right = sample(PAPER, "analytic:physical", LUMPED, usual_switches(PAPER), 250, 5)
    yours = sample(arm, "analytic:physical", LUMPED, usual_switches(PAPER), 250, 5)
    assert not off.any()
    found = differences.explain(EntryPlace("force", 1), (yours.force() - right.force())[:, 1], 1e5)
    assert found is not None
    errors = [
        describe_term_error(error) for each in (found.errors, *found.others) for error in each
    ]
    assert "backlash 0 where b belongs, in mesh force pr1" in errors


def test_a_torque_on_the_wrong_joint_is_named():
    differences, _ = _forces()
    place, torque = EntryPlace("force", 2), differences.states.torque
    (own,) = (p for p in differences.terms.entry(place) if p.key.signal == "T_1")
    lever = own.monomial.value(differences.values)
    found = differences.explain(place, lever * (torque[:, 1] - torque[:, 0]), 1e3)
    assert found is not None
    assert (found.errors[0].yours, found.errors[0].right) == ("T_2", "T_1")
    assert (
        TermKey((0, 0), "cos", "T_1") in differences.fit_difference(torque[:, 0], 1e3).coefficients
    )
