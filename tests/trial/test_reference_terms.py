"""The reference terms with numbers put in is the compiled model, in any linear coordinates."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from syrupy.assertion import SnapshotAssertion

from crosscheck.checks.scales import largest_stiffness
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.drive import torques_along
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.registry import build
from crosscheck.trial.changes.arms.letters import collect_arm_values
from crosscheck.trial.changes.arms.mesh_forces import compute_signals, list_mesh_laws
from crosscheck.trial.changes.arms.segments import build_reference_terms, evaluate_entry, rate_name
from crosscheck.trial.coordinates.build import LAYOUTS, build_frame
from crosscheck.trial.coordinates.states import UserState
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.judge.entries import EntryPlace
from tests.any_arms import any_arms
from tests.draws import examples
from tests.loops import require_items

COUNT = 5
LEVELS = {
    "": "analytic:physical",
    **{level: f"analytic:{level}" for level in ("links", "carriers", "armature", "coupled")},
}


@st.composite
def coordinates_of(draw, gearing: str, arm: Arm) -> Coordinates:
    """Named coordinates of any kind, or whole or any numbers of a matrix."""
    kind = draw(st.sampled_from(("named", "named", "named", "whole", "numbers")))
    if kind == "named":
        links = draw(st.sampled_from(("relative", "absolute")))
        gears = draw(st.sampled_from(("displacements", "angles")))
        return Coordinates(gearing, links, gears)
    n = len(LAYOUTS[gearing](arm))
    generator = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    upper = np.triu(generator.integers(-1, 2, (n, n)), 1) + np.eye(n)
    matrix = upper if kind == "whole" else upper * generator.uniform(0.5, 2.0, (n, n))
    return Coordinates(gearing, matrix=matrix)


@pytest.mark.parametrize(
    ("gearing", "level", "work"),
    [
        *product(("rigid",), sorted(LEVELS)[1:], ("paper",)),
        *product(("lumped", "free"), ("",), ("paper", "conservative")),
    ],
)
@settings(max_examples=examples(3, 30))
@given(st.data(), st.integers(0, 2**32 - 1))
def test_reference_terms_are_the_model(gearing, level, work, data, seed):
    """At random states with teeth in contact and apart, torques of a PD law."""
    arm = data.draw(any_arms(data.draw(st.integers(1, 4)), unlike=gearing == "free"))
    chosen = {"damping": data.draw(st.sampled_from(("always", "contact")))}
    if gearing != "rigid":
        chosen["planets"] = gearing
    switches = usual_switches(arm, **chosen, mesh_work=work)
    frame = build_frame(data.draw(coordinates_of(gearing, arm)), arm)
    model = build(LEVELS[level], arm, load_scenario("pd"), switches)
    J, layout, generator = frame.matrix, frame.layout, np.random.default_rng(seed)
    n, theta = len(layout), layout.theta
    q, v = generator.uniform(-3, 3, (2, COUNT, n))
    q[:, ~layout.angular] *= 3e-5
    v[:, ~layout.angular] *= 1e-2
    x, u = (each @ np.linalg.inv(J).T for each in (q, v))
    q, v, time = x @ J.T, u @ J.T, generator.uniform(0, 2, COUNT)
    torque = torques_along(model.drive, time, q[:, theta], v[:, theta])
    signals = compute_signals(arm, layout, model.switches, UserState(time, q, v, q, v, torque))
    signals |= {rate_name(own): u[:, k] for k, own in enumerate(frame.names)}
    largest = max(float(np.abs(column).max()) for column in signals.values())
    known = build_reference_terms(frame, arm, model.switches, level)
    values, angles = collect_arm_values(arm), q[:, theta]

    def at(place: EntryPlace) -> np.ndarray:
        return evaluate_entry(known.entry(place), values, angles, signals)

    mass = np.array([J.T @ model.mass_matrix(each) @ J for each in q])
    bias = np.array([J.T @ model.bias(*each) for each in zip(q, v, strict=True)])
    force = np.array(
        [J.T @ model.generalized_force(*each) for each in zip(time, q, v, strict=True)]
    )
    size = np.sqrt(np.einsum("kii->ki", mass))
    for i, j in require_items(product(range(n), repeat=2)):
        off = np.abs(at(EntryPlace("mass_matrix", i, j)) - mass[:, i, j])
        assert (off <= 1e-10 * size[:, i] * size[:, j]).all()
    # Slopes of M are no larger than M's sizes times the joints' turning with x.
    turning, speed = np.abs(J[theta]).sum(), (size * np.abs(u)).sum(axis=1)
    # A displacement is a sum of the user's coordinates, which may be far larger than it is.
    shifts = (np.abs(x) @ np.abs(J).T)[:, ~layout.angular]
    rounded_m = n * np.finfo(float).eps * shifts.max(initial=0.0)
    teeth = rounded_m * largest_stiffness(arm) if shifts.size else 0.0
    for i in range(n):
        rates = ((j, k) for j in range(n) for k in range(j, n))
        found = sum(at(EntryPlace("bias", i, rates=(j, k))) * u[:, j] * u[:, k] for j, k in rates)
        limit = size[:, i] * np.abs(u).sum(axis=1) + speed
        assert (np.abs(found - bias[:, i]) <= 1e-10 * turning * speed * limit).all()
        column = np.abs(J[:, i])
        limit = 1e-9 * (1 + largest) * column.max() + teeth * column.sum()
        assert at(EntryPlace("force", i)) == pytest.approx(force[:, i], abs=limit, rel=1e-9)


def test_a_law_of_unlike_planets_is_that_of_each():
    arm = load_arm("planets-apart")
    laws = list_mesh_laws(arm, LAYOUTS["free"](arm), usual_switches(arm))
    doubled = {law.meshes: law.arm.joints[0] for law in laws if law.yours == "2 b"}
    assert doubled["pr1"].ring_mesh.backlash_m == pytest.approx((100e-6, 100e-6, 170e-6))


def test_other_laws_say_in_which_meshes_and_what_is_another(snapshot: SnapshotAssertion):
    """Each differs from the arm's own in meshes that it names, in a switch or in its phase."""
    arm, lines = load_arm("probe"), list[str]()
    own = usual_switches(arm)
    for law in list_mesh_laws(arm, LAYOUTS["lumped"](arm), own):
        meshes = [
            f"{pair}{number}"
            for number, joint in enumerate(arm.joints, start=1)
            for pair, side in (("sp", "sun_mesh"), ("pr", "ring_mesh"))
            if getattr(law.arm.joints[number - 1], side) != getattr(joint, side)
        ]
        assert set(meshes) <= set(law.meshes.split(", "))
        assert bool(meshes) + (law.switches != own) + law.words.startswith("phase of") == 1
        lines.append(f"{law.words}: {law.yours} where {law.right} belongs")
    assert "\n".join(lines) == snapshot
