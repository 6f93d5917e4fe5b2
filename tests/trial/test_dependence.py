"""Right models are blamed for no error, whatever number of the file they have in their own code."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm, Direct
from crosscheck.models.errors import InputError
from crosscheck.testing import assert_agrees
from crosscheck.trial.changes.arms import dependence
from crosscheck.trial.input.equations import Coordinates, Equations
from tests import mixed_arms
from tests.trial.test_trial import trial_of

G = 9.81
Body = tuple[float, float, float, float]  # mass, length, centre, inertia
UNLIKE = (1.3, 0.5, 0.23, 0.03), (0.9, 0.4, 0.17, 0.012)
ALIKE = ((1.0, 1.0, 0.5, 1 / 12),) * 2
POINTS = (1.3, 0.5, 0.5, 0.0), (0.9, 0.4, 0.4, 0.0)


def arm_of(*bodies: Body, payload: float = 0.0) -> Arm:
    """A direct arm that hangs along x."""
    fields = ("mass_kg", "length_m", "com_m", "inertia_kg_m2")
    motor = mixed_arms.direct(motor_mass_kg=0.0, rotor_inertia_kg_m2=0.0)
    return mixed_arms.arm_of(
        *[motor] * len(bodies),
        links=[dict(zip(fields, body, strict=True)) for body in bodies],
        payload_kg=payload,
        gravity=(G, 0.0),
        name="hanging",
    )


def bodies_of(arm: Arm) -> list[Body]:
    return [(b.mass_kg, b.length_m, b.com_m, b.inertia_kg_m2) for b in arm.links]


def pendulum(bodies: Any, g: float, payload: float = 0.0, driven: bool = True) -> Equations:
    """A chain by absolute angles from x: sums over point masses and inertias."""
    n = len(bodies)
    levers = np.array(
        [[*(b[1] for b in bodies[:i]), bodies[i][2], *[0.0] * (n - i - 1)] for i in range(n)]
    )
    tip = np.array([b[1] for b in bodies])
    parts = [*zip([b[0] for b in bodies], levers, strict=True), (payload, tip)]
    turned = np.tril(np.ones((n, n)))
    own = np.diag([b[3] for b in bodies])

    def mass_matrix(q: np.ndarray) -> np.ndarray:
        a = np.cumsum(q)
        inertia = own + sum(m * np.outer(c, c) * np.cos(a[:, None] - a) for m, c in parts)
        return turned.T @ inertia @ turned

    def bias(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        a, w = np.cumsum(q), np.cumsum(v)
        return turned.T @ sum(
            m * (np.outer(c, c) * np.sin(a[:, None] - a)) @ w**2 for m, c in parts
        )

    def weight(q: np.ndarray) -> np.ndarray:
        return turned.T @ sum(-m * g * c * np.sin(np.cumsum(q)) for m, c in parts)

    if not driven:
        return Equations(mass_matrix, bias, force=lambda q: weight(q))
    return Equations(mass_matrix, bias, force=lambda q, torque: torque + weight(q))


def alike_rods(arm: Arm) -> Equations:
    """Both links by the first one's mass and length, as rods."""
    m, length = arm.links[0].mass_kg, arm.links[0].length_m
    return pendulum([(m, length, length / 2, m * length**2 / 12)] * len(arm.links), G)


def at_the_ends(arm: Arm) -> Equations:
    return pendulum([(b.mass_kg, b.length_m, b.length_m, 0.0) for b in arm.links], G)


def fixed_but_in_the_weight(arm: Arm) -> Equations:
    """The first mass from the file in the weight alone."""
    (_, *others), second = bodies_of(arm)
    by_file, fixed = (
        pendulum([(mass, *others), second], arm.gravity_m_per_s2[0], arm.payload_mass_kg)
        for mass in (arm.links[0].mass_kg, UNLIKE[0][0])
    )
    return replace(fixed, force=by_file.force)


RIGHT: dict[str, tuple[Arm, Callable[[Arm], Equations], set[str]]] = {
    "9.81 in the code": (
        arm_of(*UNLIKE, payload=0.6),
        lambda arm: pendulum(bodies_of(arm), G, arm.payload_mass_kg),
        {"gravity_m_per_s2[0]"},
    ),
    "a mass of one part": (
        arm_of(*UNLIKE, payload=0.6),
        fixed_but_in_the_weight,
        {"links[0].mass_kg"},
    ),
    "no payload": (
        arm_of(*UNLIKE),
        lambda arm: pendulum(bodies_of(arm), arm.gravity_m_per_s2[0]),
        {"payload_mass_kg"},
    ),
    "three equal rods": (
        arm_of(*ALIKE, ALIKE[0]),
        alike_rods,
        {f"links[{k}].{f}" for k in range(3) for f in ("com_m", "inertia_kg_m2")}
        | {f"links[{k}].mass_kg" for k in (1, 2)}
        | {"links[1].length_m", "gravity_m_per_s2[0]", "payload_mass_kg"},
    ),
    "point masses": (
        arm_of(*POINTS),
        at_the_ends,
        {f"links[{k}].{f}" for k in range(2) for f in ("com_m", "inertia_kg_m2")}
        | {"gravity_m_per_s2[0]", "payload_mass_kg"},
    ),
}


@pytest.mark.parametrize("kind", RIGHT)
def test_a_right_model_has_one_note_at_most_and_no_error(kind):
    arm, factory, numbers = RIGHT[kind]
    trial = trial_of(factory, arm)
    assert (trial.exit_code, trial.diagnosis.entries, trial.diagnosis.hidden) == (0, (), ())
    assert {each.name for each in trial.diagnosis.ignored_numbers} == numbers
    shown = {each.name for each in trial.diagnosis.ignored_numbers if each.value or each.goes_with}
    notes = list(trial.notes)
    assert len(notes) == bool(shown)
    # Of what is 0 in the file and in the equations nothing is said.
    assert {name for name in numbers if name in "".join(notes)} == shown


def test_motors_that_the_arm_has_not_are_no_error():
    """All levels are alike there; other arms, which have motors, tell which of them it is."""

    def factory(arm: Arm) -> Equations:
        (m1, l1, d1, i1), (m2, l2, d2, i2) = bodies_of(arm)
        (_, rotor1), (motor, rotor2) = (
            (joint.motor_mass_kg, joint.rotor_inertia_kg_m2)
            for joint in arm.joints
            if isinstance(joint, Direct)
        )
        both = m1 + motor
        centre = (m1 * d1 + motor * l1) / both
        about = i1 + rotor1 + m1 * d1**2 + motor * l1**2 - both * centre**2
        bodies = (both, l1, centre, about), (m2, l2, d2, i2 + rotor2)
        return pendulum(bodies, arm.gravity_m_per_s2[0], arm.payload_mass_kg)

    trial = trial_of(factory, arm_of(*UNLIKE, payload=0.6))
    assert (trial.exit_code, trial.diagnosis.entries, trial.diagnosis.hidden) == (0, (), ())
    links = trial_of(lambda arm: replace(factory(arm), level="links"), arm_of(*UNLIKE, payload=0.6))
    assert (links.level, bool(links.diagnosis.hidden)) == ("links", True)  # as they state


def test_numbers_that_may_go_with_a_driver_are_chosen_alone_and_together_but_never_all():
    chosen = dependence._subsets({"a": 1, "b": 2, "c": -1})
    assert chosen[:3] == [{"a": 1}, {"b": 2}, {"c": -1}]
    assert chosen[3:] == [{"a": 1, "b": 2}, {"a": 1, "c": -1}, {"b": 2, "c": -1}]


def test_a_pendulum_whose_mass_cancels_is_not_blamed():
    """Of one point mass the acceleration hangs on the payload in company of its length alone."""

    def factory(arm: Arm) -> Equations:
        return Equations(acceleration=lambda q, v: -G / 1.0 * np.sin(q))

    trial = trial_of(factory, arm_of((1.0, 1.0, 1.0, 0.0)))
    assert (trial.exit_code, trial.diagnosis.entries, trial.diagnosis.hidden) == (0, (), ())


def test_an_inertia_next_to_nothing_may_be_left_out():
    """The file's stand-in for a point mass, 1e-8 of M, is judged as one, and that is said."""
    bodies = tuple((*body[:3], 1.2e-9) for body in POINTS)
    trial = trial_of(lambda arm: Equations(at_the_ends(arm).mass_matrix), arm_of(*bodies))
    assert (trial.exit_code, trial.diagnosis.entries, trial.diagnosis.hidden) == (0, (), ())
    assert "links[0].inertia_kg_m2, links[1].inertia_kg_m2, and the file's" in trial.notes[0]
    assert "judged as point masses" in trial.notes[0]
    whole = trial_of(
        lambda arm: Equations(pendulum(bodies_of(arm), G).mass_matrix), arm_of(*bodies)
    )
    assert (whole.exit_code, whole.notes) == (0, ())


@pytest.mark.parametrize(("numbers", "g"), [(UNLIKE, G), (ALIKE, None)], ids=["wrong", "hidden"])
def test_a_slip_is_named_beside_a_literal_and_where_equal_numbers_hide_it(numbers, g):
    """L1 for L2 at the payload, in the weight of both rows alone; equal links do not show it."""

    def factory(arm: Arm) -> Equations:
        own = bodies_of(arm)
        gravity = g or arm.gravity_m_per_s2[0]
        right = pendulum(own, gravity, arm.payload_mass_kg)
        error = arm.payload_mass_kg * gravity * (own[1][1] - own[0][1])

        def force(q: np.ndarray, torque: np.ndarray) -> np.ndarray:
            return right.force(q, torque) + error * math.sin(q[0] + q[1])

        return Equations(right.mass_matrix, right.bias, force=force)

    trial = trial_of(factory, arm_of(*numbers, payload=0.6))
    hidden = g is None
    assert trial.exit_code == (not hidden)
    notes = list(trial.notes) if hidden else trial.diagnosis.notes
    assert bool(trial.diagnosis.hidden) == hidden
    assert all("L1 where L2 belongs?" in line for line in notes)
    assert len(notes) == 1
    if hidden:
        assert notes[0].startswith("Right on this arm.")
    else:
        assert "gravity_m_per_s2[0] = 9.81" in trial.notes[0]


def test_what_is_zero_in_the_file_and_in_the_equations_makes_no_note():
    def missing_payload_alone(own: Arm) -> Equations:
        right = pendulum(bodies_of(own), 9.8, own.payload_mass_kg)
        return replace(right, mass_matrix=lambda q: right.mass_matrix(q) * [[1, 0.9], [0.9, 1]])

    notes = " ".join(trial_of(missing_payload_alone, arm_of(*UNLIKE)).notes)
    assert "nor has this arm" not in notes
    assert "rotor" not in notes


def test_one_line_where_every_part_raises_the_same():
    def factory(arm: Arm) -> Equations:
        def part(q: np.ndarray) -> float:
            return None * arm.payload_mass_kg

        return Equations(part, force=part, coordinates=Coordinates(links="absolute"))

    with pytest.raises(
        InputError, match=r"every part raises TypeError.*py, line \d+\); hanging has 2"
    ):
        trial_of(factory, arm_of(*UNLIKE))


@pytest.mark.parametrize(
    ("argument", "value", "allowed"),
    [
        ("arm", 3, "must be an Arm"),
        ("scenarios", "pd", "must be a list"),
        ("scenarios", [3], "must be a Scenario"),
        ("switches", [], "must be Switches"),
        ("level", "nope", "must be one of links, carriers, armature, coupled"),
        ("quick", 1, "must be True or False"),
        ("jobs", 0, "must be a whole number, 1 to"),
        ("jobs", True, "must be a whole number, 1 to"),
        ("seed", -1, "must be 0 to"),
        ("name", None, "must be a text"),
    ],
)
def test_an_argument_of_assert_agrees_is_refused_by_name(argument, value, allowed):
    arguments = {"arm": arm_of(*UNLIKE), argument: value}
    with pytest.raises(InputError, match=rf"argument {argument}.*{allowed}"):
        assert_agrees(RIGHT["no payload"][1], **arguments)


def test_levels_that_are_equal_are_one_line():
    """An arm without gears and motors has no four levels to be compared with."""
    arm = arm_of(*UNLIKE)
    result = trial_of(lambda own: pendulum(bodies_of(own), G, own.payload_mass_kg), arm)
    assert result.headline == "yours on hanging agrees with the rigid arm"
    assert [(each.level, each.entries) for each in result.distances] == [("links", 0)]
