"""The same arm described in two ways is the same arm, in every model."""

import pickle
from typing import Any

import numpy as np
import pytest

from crosscheck.checks.answers import sample_states
from crosscheck.models.arm.arm import Arm
from crosscheck.models.interface import STATE_ABILITIES
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.registry import build, model_names

EPS = float(np.finfo(float).eps)
# Roundings of a number given instead of worked out; arcs of the gears hold theirs 1e4 times.
ROUNDING, ROUNDING_OF_FORCES = 1000 * EPS, 1e-10
STATES, SEED = 12, 4

every_model = pytest.mark.parametrize("name", [*model_names("geared"), *model_names("rigid")])


def changed(arm: Arm, **updates: Any) -> Arm:
    return Arm.model_validate(arm.model_dump() | updates)


def values(name: str, arm: Arm, quantity: str) -> np.ndarray:
    """A model's quantity at random states, (states, n) or (states, n, n)."""
    model = build(name, arm, load_scenario("pd"))
    states = sample_states(model.layout, arm, STATES, SEED)
    if quantity == "mass_matrix":
        return np.array([model.mass_matrix(q) for q in states.q])
    if quantity == "bias":
        return np.array([model.bias(q, v) for q, v in zip(states.q, states.v, strict=True)])
    answer = getattr(model, quantity)
    return np.array([answer(*state) for state in zip(*states, strict=True)])


def assert_same(name: str, one: Arm, other: Arm) -> None:
    """To the rounding of the numbers that differ, each component against its own size."""
    for quantity in STATE_ABILITIES:
        first, second = (values(name, arm, quantity) for arm in (one, other))
        size = np.sqrt((first**2).mean(axis=0))
        exact = quantity in ("mass_matrix", "bias")
        tolerance = ROUNDING if exact else ROUNDING_OF_FORCES
        natural = size.max() * EPS if exact else 0.0
        assert (abs(first - second) <= tolerance * size + natural).all(), quantity


@every_model
def test_inertia_is_equivalent_mass_times_base_radius_squared(name):
    arm = load_arm("three-unlike")
    joints = []
    for joint in arm.model_dump()["joints"]:
        cosine = np.cos(np.radians(joint["pressure_angle_deg"]))
        turned = dict(joint)
        for part, teeth in (
            ("sun", joint["sun_teeth"]),
            ("planet", joint["planet_teeth"]),
            ("carrier", joint["sun_teeth"] + joint["planet_teeth"]),
        ):
            squared = (joint["module_m"] * teeth / 2 * cosine) ** 2
            mass, inertia = (f"{part}_{form}" for form in ("equivalent_mass_kg", "inertia_kg_m2"))
            if joint[mass] is None:
                turned |= {mass: joint[inertia] / squared, inertia: None}
            else:
                turned |= {mass: None, inertia: joint[mass] * squared}
        joints.append(turned)
    assert_same(name, arm, changed(arm, joints=joints))


@every_model
def test_body_with_a_rods_mass_and_inertia_is_the_rod(name):
    arm = load_arm("three-unlike")
    links = []
    for link in arm.model_dump()["links"]:
        if link["mass_kg"] is None:
            mass = link["cross_section_m2"] * link["density_kg_per_m3"] * link["length_m"]
            inertia = mass * link["length_m"] ** 2 / 12
            rod = {"cross_section_m2": None, "density_kg_per_m3": None}
            link |= {**rod, "mass_kg": mass, "inertia_kg_m2": inertia}
        links.append(link)
    assert_same(name, arm, changed(arm, links=links))


def test_equal_records_have_one_hash_and_changed_copies_another(labelled):
    """The hash that is kept is neither copied nor pickled: another process has other ones."""
    kept, again = hash(labelled), load_arm(labelled.name)
    heavier = labelled.model_copy(update={"payload_mass_kg": labelled.payload_mass_kg + 1})
    assert again is not labelled
    assert hash(again) == kept != hash(heavier)
    assert b"_hash" not in pickle.dumps(labelled)
