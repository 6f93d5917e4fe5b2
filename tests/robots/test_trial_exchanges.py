"""Two numbers of a robot's file exchanged, shifted or in another order: the cause is named.

Each is planted into the numbers that the project's own derivation takes.
"""

import re
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from operator import attrgetter
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import sample_states
from crosscheck.models.robot.robot import RIGID, Placement, Robot
from crosscheck.trial.changes.mistakes import (
    BODY_FIELDS,
    JOINT_FIELDS,
    ROTOR_FIELDS,
    exchange_fields,
    list_body_exchanges,
    list_body_parts,
    list_frame_mistakes,
    list_joint_moves,
)
from crosscheck.trial.changes.table import ChangeTable
from crosscheck.trial.input.equations import Equations
from tests.loops import require_items
from tests.robots import chains
from tests.robots.test_trial import equations
from tests.robots.trials import run_robot_trial

Change = Callable[[Robot], Robot]


@pytest.fixture(scope="module")
def tree() -> Robot:
    """A trunk with two arms and rotors, no number of it twice."""
    solids = [
        chains.Solid(m, com, (a, 0.1 * a, -0.05 * a, 1.2 * a, 0.07 * a, 1.5 * a))
        for m, com, a in (
            (9.0, (0.02, 0.01, 0.2), 0.3),
            (2.2, (0.01, 0.12, -0.013), 0.02),
            (2.4, (0.012, -0.11, -0.015), 0.023),
        )
    ]
    names = "trunk", "left", "right"
    rotors = {"turn": (100.0, 2e-4), "l": (80.0, 9e-5), "r": (-60.0, 7e-5)}
    return chains.robot(
        chains.urdf(
            chains.link("base"),
            *map(chains.link, names, solids),
            chains.joint("turn", "base", "trunk", at=(0.1, 0.05, 0.4)),
            chains.joint("l", "trunk", "left", axis=(0.6, 0, 0.8), at=(0.02, 0.2, 0.35)),
            chains.joint("r", "trunk", "right", axis=(0, 1, 0), at=(0.03, -0.21, 0.36)),
        ),
        {
            name: {"kind": "geared", "ratio": ratio, "rotor_inertia_kg_m2": inertia}
            for name, (ratio, inertia) in rotors.items()
        },
    )


def exchange(kind: str, field: str) -> Change:
    """A field of the last two parts of a kind."""

    def change(own: Robot) -> Robot:
        first, left, right = getattr(own, kind)
        pair = (
            replace(part, **{field: getattr(other, field)})
            for part, other in ((left, right), (right, left))
        )
        changed: dict[str, Any] = {kind: (first, *pair)}
        return replace(own, **changed)

    return change


def put(kind: str, **fields: Callable[[Any], object]) -> Change:
    """Other values in the last part of a kind."""

    def change(own: Robot) -> Robot:
        *others, last = getattr(own, kind)
        new = {name: function(getattr(last, name)) for name, function in fields.items()}
        changed: dict[str, Any] = {kind: (*others, replace(last, **new))}
        return replace(own, **changed)

    return change


def shift_masses(own: Robot) -> Robot:
    moved = own.bodies[1:] + own.bodies[:1]
    bodies = (replace(b, mass=n.mass) for b, n in zip(own.bodies, moved, strict=True))
    return replace(own, bodies=tuple(bodies))


def order_place(placement: Placement) -> Placement:
    return replace(placement, position=placement.position[[1, 2, 0]])


EXCHANGES: dict[str, Change] = {
    "l and r: ratio exchanged": exchange("rotors", "ratio"),
    "l and r: rotor's inertia exchanged": exchange("rotors", "inertia"),
    "left and right: mass exchanged": exchange("bodies", "mass"),
    "left and right: centre of mass exchanged": exchange("bodies", "com"),
    "left and right: inertia exchanged": exchange("bodies", "inertia"),
    "joint l and joint r: axis exchanged": exchange("joints", "axis"),
    "every part has the mass of the next": shift_masses,
    "right: its centre of mass in another order, y, z, x": put(
        "bodies", com=lambda com: com[[1, 2, 0]]
    ),
    "right: its six inertias read in the order xx, yy, zz, xy, xz, yz": put(
        "bodies",
        inertia=lambda given: np.array(
            [
                [given[0, 0], given[1, 1], given[1, 2]],
                [given[1, 1], given[0, 1], given[2, 2]],
                [given[1, 2], given[2, 2], given[0, 2]],
            ]
        ),
    ),
    "joint r: its place in another order, y, z, x": put("joints", placement=order_place),
}


@pytest.mark.parametrize("words", EXCHANGES)
def test_what_is_exchanged_is_named(tree, words):
    found = run_robot_trial(equations(EXCHANGES[words](tree)), tree).diagnosis
    assert found.level == "coupled"
    assert words in found.explanations


def test_what_is_exchanged_in_one_part_alone_is_named(tree):
    own, wrong = equations(tree), equations(EXCHANGES["left and right: mass exchanged"](tree))
    found = run_robot_trial(replace(own, gravity=wrong.gravity), tree).diagnosis
    assert found.explanations == ()
    assert any("left and right: mass exchanged" in note for note in found.notes)


def test_exchanged_rows_and_rates_are_named(tree):
    own, order = equations(tree), [0, 2, 1]
    gravity, bias = own.gravity, own.bias
    for part, wrong, words in (
        ("gravity", lambda q: gravity(q)[order], "gravity: the rows of l and r"),
        ("bias", lambda q, v: bias(q, v[order]), "bias: the rates of l and r"),
    ):
        found = run_robot_trial(replace(own, **{part: wrong}), tree).diagnosis
        assert f"{words} are exchanged in it" in found.notes


def test_a_ratio_of_turns_is_reported_as_such(tree):
    used = put("rotors", ratio=lambda ratio: ratio / (2 * np.pi))(tree)
    (words, *_) = run_robot_trial(equations(used), tree).diagnosis.explanations
    assert words.endswith("ratio = -9.5493 (file: -60), 1/(2 pi) of it: turns taken for radians?")


def test_masses_exchanged_in_the_gravity_of_accelerations(tree):
    bodies = tree.bodies
    masses = [replace(bodies[n], mass=bodies[3 - n].mass) for n in (1, 2)]
    right = AnalyticRobot(tree, "coupled")
    other = AnalyticRobot(replace(tree, bodies=(bodies[0], *masses)), "coupled")

    def acceleration(q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        mass, bias, _ = right.terms(q[None], v[None])
        return np.linalg.solve(mass[0], torque - bias[0] - other.gravity(q[None])[0])

    trial = run_robot_trial(Equations(acceleration=acceleration), tree)
    expected = "left and right: mass exchanged, in its gravity alone"
    assert expected in trial.diagnosis.explanations


@pytest.mark.parametrize("seed", [5, 9])
def test_a_table_has_what_another_robot_changes(seed):
    """Of bodies, joints, rotors and stages taken for others, at every level: to rounding."""
    robot, rng = chains.random_chain(seed), np.random.default_rng(seed)
    states = sample_states(robot, 3, seed)
    table = ChangeTable(SimpleNamespace(robot=robot, states=states))
    changed = [each.put(each.value + each.step / 2) for each in table.numbers]
    for level in require_items(RIGID):
        mistakes = [*table.joint_moves, *list_frame_mistakes(robot, level)]
        robots = [*changed, *(each.robot for each in mistakes)]
        together, base = table.compute_changes(robots, level), table.compute_base(level)
        for number in require_items(rng.choice(len(robots), 40, replace=False)):
            exact = AnalyticRobot(robots[number], level).terms(*states[:2])
            for change, right, other in require_items(zip(together, base, exact, strict=True)):
                np.testing.assert_allclose(right + change[number], other, rtol=1e-9, atol=1e-10)


FIELDS = {
    "mass": "mass",
    "centre": "com",
    "inertia": "inertia",
    "ratio": "ratio",
    "axis": "axis",
    "place": "placement.position",
    "turn": "placement.rotation",
}
CALLED = {"centre of mass": "centre", "inertias": "inertia", "rpy|roll|pitch|yaw": "turn"}


def test_the_fields_that_words_name_are_those_that_differ():
    """Of all that may be exchanged, copied, shifted or in another order."""
    robot, met = chains.random_chain(9), set[frozenset[str]]()
    parts, moves = list_body_parts(robot), list_joint_moves(robot)
    rotors = [replace(robot.rotors[0], inertia=n, ratio=n) for n in (1.0, 2.0, 3.0)]
    for records, changes in (
        ([each.in_link for each in parts], [*list_body_exchanges(parts)]),
        (rotors, [*exchange_fields("abc", rotors, ROTOR_FIELDS)]),
        (robot.joints, [(each.words, dict(enumerate(each.robot.joints))) for each in moves]),
    ):
        for words, changed in require_items(changes):
            text = re.sub(r"joint \w+", "", words)
            for old, new in CALLED.items():
                text = re.sub(old, new, text)
            named = {field for field in FIELDS if re.search(rf"\b{field}\b", text)}
            differing = {
                field
                for (number, other), (field, path) in product(changed.items(), FIELDS.items())
                if path.split(".")[0] in vars(other)
                and not np.array_equal(*map(attrgetter(path), (records[number], other)))
            }
            assert differing in (named, set()), words  # a place of zeros is the same in any order
            met.add(frozenset(differing))
    tables = BODY_FIELDS, ROTOR_FIELDS, JOINT_FIELDS
    assert len(met - {frozenset()}) == sum(map(len, tables)) - 1  # two have an inertia alone
