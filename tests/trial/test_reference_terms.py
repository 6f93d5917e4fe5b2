"""The reference terms with numbers put in is the compiled model, in any linear coordinates."""

from __future__ import annotations

import random
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.checks.scales import largest_stiffness
from crosscheck.models.arm.planets import usual_switches
from crosscheck.trial.changes.arms.letters import collect_arm_values
from crosscheck.trial.changes.arms.segments import build_reference_terms, evaluate_entry
from crosscheck.trial.judge.entries import EntryPlace
from tests.any_arms import any_arms
from tests.draws import examples
from tests.loops import require_items
from tests.trial.states import Sample, drawn_coordinates, sample

COUNT = 5
LEVELS = {
    "": "analytic:physical",
    **{level: f"analytic:{level}" for level in ("links", "carriers", "armature", "coupled")},
}


def _layout_size(arm, gearing):
    from crosscheck.trial.coordinates.build import LAYOUTS

    return len(LAYOUTS[gearing](arm))


@st.composite
def trials(draw, gearing, work):
    """An arm and what it is described by."""
    joints = draw(st.integers(1, 4))
    arm = draw(any_arms(joints, unlike=gearing == "free"))
    chooser = random.Random(draw(st.integers(0, 2**32 - 1)))
    chosen = {"damping": draw(st.sampled_from(("always", "contact")))}
    if gearing != "rigid":
        chosen["planets"] = gearing
    switches = usual_switches(arm, **chosen, mesh_work=work)
    coordinates = drawn_coordinates(chooser, gearing, _layout_size(arm, gearing))
    return arm, coordinates, switches, chooser.randrange(2**32)


@pytest.mark.parametrize(
    ("gearing", "level", "work"),
    [
        *product(("rigid",), sorted(LEVELS)[1:], ("paper",)),
        *product(("lumped", "free"), ("",), ("paper", "conservative")),
    ],
)
@settings(max_examples=examples(3, 30))
@given(st.data())
def test_dictionary_is_the_model(gearing, level, work, data):
    arm, coordinates, switches, seed = data.draw(trials(gearing, work))
    sampled = sample(arm, LEVELS[level], coordinates, switches, COUNT, seed)
    known = build_reference_terms(sampled.frame, arm, sampled.model.switches, level)
    values = collect_arm_values(arm)

    def at(place: EntryPlace) -> np.ndarray:
        return evaluate_entry(known.entry(place), values, sampled.angles, sampled.signals)

    n = len(sampled.frame.names)
    mass = sampled.mass()
    size = np.sqrt(np.einsum("kii->ki", mass))
    for i in require_items(range(n)):
        for j in require_items(range(n)):
            off = np.abs(at(EntryPlace("mass_matrix", i, j)) - mass[:, i, j])
            assert (off <= 1e-10 * size[:, i] * size[:, j]).all()
    _bias_agrees(sampled, at, size)
    _force_agrees(sampled, at)


def _bias_agrees(sampled: Sample, at, size: np.ndarray) -> None:
    n, v = len(sampled.frame.names), sampled.v
    speed = (size * np.abs(v)).sum(axis=1)
    for i, whole in enumerate(sampled.bias().T):
        total = np.zeros(len(v))
        for j in range(n):
            for k in range(j, n):
                total += at(EntryPlace("bias", i, rates=(j, k))) * v[:, j] * v[:, k]
        # Slopes of M are no larger than M's sizes times the joints' turning with x.
        turning = np.abs(sampled.frame.matrix[sampled.frame.layout.theta]).sum()
        assert (
            np.abs(total - whole)
            <= 1e-10 * turning * speed * (size[:, i] * np.abs(v).sum(axis=1) + speed)
        ).all()


def _force_agrees(sampled: Sample, at) -> None:
    J = np.abs(sampled.frame.matrix)
    largest = max(float(np.abs(column).max()) for column in sampled.signals.values())
    # A displacement is a sum of the user's coordinates, which may be far larger than it is.
    shifts = (np.abs(sampled.x) @ J.T)[:, ~sampled.frame.layout.angular]
    rounded_m = len(J) * np.finfo(float).eps * shifts.max(initial=0.0)
    teeth = rounded_m * largest_stiffness(sampled.model.arm) if shifts.size else 0.0
    for i, whole in enumerate(sampled.force().T):
        own = at(EntryPlace("force", i))
        limit = 1e-9 * (1 + largest) * J[:, i].max() + teeth * J[:, i].sum()
        assert own == pytest.approx(whole, abs=limit, rel=1e-9)
