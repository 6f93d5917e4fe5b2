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
STATES, MANY, SEED = 12, 60, 4
ROWS = (8, 16, 32, 64)
MEAN, AMPLITUDE = 9e7, 1.6e7
SINE = {"law": "sine", "mean_N_per_m": MEAN, "amplitude_N_per_m": AMPLITUDE}
SQUARE = {
    "law": "square",
    "contact_ratio": 1.62,
    "least_N_per_m": 6e7,
    "largest_N_per_m": 9e7,
    "harmonics": 6,
}
MESHES = ("sun_mesh", "ring_mesh")

every_geared_model = pytest.mark.parametrize("name", model_names("geared"))
every_model = pytest.mark.parametrize("name", [*model_names("geared"), *model_names("rigid")])


def changed(arm: Arm, **updates: Any) -> Arm:
    return Arm.model_validate(arm.model_dump() | updates)


def with_law(arm: Arm, law: dict[str, object]) -> Arm:
    """The arm, every mesh of it with the law."""
    joints = [
        joint | {mesh: joint[mesh] | {"stiffness": law} for mesh in MESHES}
        for joint in arm.model_dump()["joints"]
    ]
    return changed(arm, joints=joints)


def values(name: str, arm: Arm, quantity: str, count: int = STATES) -> np.ndarray:
    """A model's quantity at random states, (count, n) or (count, n, n)."""
    model = build(name, arm, load_scenario("pd"))
    states = sample_states(model.layout, arm, count, SEED)
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


@every_geared_model
def test_sine_law_is_a_fourier_series_of_one_term(name):
    arm = load_arm("three-unlike")
    fourier = {"law": "fourier", "mean_N_per_m": MEAN, "sine_N_per_m": [AMPLITUDE]}
    assert_same(name, with_law(arm, SINE), with_law(arm, fourier))


@every_geared_model
def test_square_law_is_the_fourier_series_of_its_wave(name):
    """Largest for a part e - 1 of a period from phase 0 on, least for the rest of it."""
    arm, orders = load_arm("three-unlike"), np.arange(1, 7)
    swing, overlap = 3e7, 0.62
    end = 2 * np.pi * overlap * orders
    fourier = {
        "law": "fourier",
        "mean_N_per_m": 6e7 + swing * overlap,
        "cosine_N_per_m": (swing * np.sin(end) / (np.pi * orders)).tolist(),
        "sine_N_per_m": (swing * (1 - np.cos(end)) / (np.pi * orders)).tolist(),
    }
    assert_same(name, with_law(arm, SQUARE), with_law(arm, fourier))


def sampled(rows: int) -> dict[str, object]:
    """The sine law as a table."""
    cycles = np.arange(rows + 1) / rows
    stiffness = MEAN + AMPLITUDE * np.sin(2 * np.pi * cycles)
    stiffness[-1] = stiffness[0]
    return {
        "law": "table",
        "phase_cycles": cycles.tolist(),
        "stiffness_N_per_m": stiffness.tolist(),
    }


@every_geared_model
def test_tables_of_a_sine_law_converge_to_it_as_splines_do(name):
    """A cubic spline misses a wave of h radians a row by at most 5/384 h^4 of its amplitude."""
    arm = undamped(load_arm("three-unlike"))

    def forces(law: dict[str, object]) -> np.ndarray:
        return values(name, with_law(arm, law), "generalized_force", MANY)

    exact = forces(SINE)
    # k of every mesh doubled: the springs' own part of every force, per N/m.
    constant = SINE | {"amplitude_N_per_m": 0.0}
    stretch = abs(forces(constant | {"mean_N_per_m": 2 * MEAN}) - forces(constant)) / MEAN
    rounding = ROUNDING_OF_FORCES * abs(exact).max()
    misses = []
    for rows in ROWS:
        off = abs(forces(sampled(rows)) - exact)
        allowed = 5 / 384 * (2 * np.pi / rows) ** 4 * AMPLITUDE * stretch
        assert (off <= allowed + rounding).all()
        misses.append(np.sqrt((off**2).mean()))
    orders = np.log2(np.divide(misses[:-1], misses[1:]))
    assert orders == pytest.approx(4.0, abs=0.3)


def undamped(arm: Arm) -> Arm:
    """The arm without mesh damping, which follows the mean stiffness."""
    none = {"damping_ratio": None, "damping_N_s_per_m": 0.0}
    joints = [
        joint | {mesh: joint[mesh] | none for mesh in MESHES}
        for joint in arm.model_dump()["joints"]
    ]
    return changed(arm, joints=joints)


def test_equal_records_have_one_hash_and_changed_copies_another(labelled):
    """The hash that is kept is neither copied nor pickled: another process has other ones."""
    kept, again = hash(labelled), load_arm(labelled.name)
    heavier = labelled.model_copy(update={"payload_mass_kg": labelled.payload_mass_kg + 1})
    assert again is not labelled
    assert hash(again) == kept != hash(heavier)
    assert b"_hash" not in pickle.dumps(labelled)
