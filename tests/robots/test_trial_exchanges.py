"""Numbers and frames of a robot that are others: what each makes of its terms."""

import re
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import sample_states
from crosscheck.models.robot.robot import RIGID, Robot
from crosscheck.trial.changes.mistakes import list_frame_mistakes
from crosscheck.trial.changes.numbers import UNITS, UNITS_OF
from crosscheck.trial.changes.table import ChangeTable
from tests.loops import require_items
from tests.robots import chains
from tests.robots.trials import robot_equations, run_robot_trial

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


def put(kind: str, **fields: Callable[[Any], object]) -> Change:
    """Other values in the last part of a kind."""

    def change(own: Robot) -> Robot:
        *others, last = getattr(own, kind)
        new = {name: function(getattr(last, name)) for name, function in fields.items()}
        changed: dict[str, Any] = {kind: (*others, replace(last, **new))}
        return replace(own, **changed)

    return change


def test_a_ratio_of_turns_is_reported_as_such(tree):
    used = put("rotors", ratio=lambda ratio: ratio / (2 * np.pi))(tree)
    (words, *_) = run_robot_trial(robot_equations(used), tree).diagnosis.explanations
    assert words.endswith("ratio = -9.5493 (file: -60), 1/(2 pi) of it: turns taken for radians?")


@pytest.mark.parametrize("seed", [5, 9])
def test_a_table_has_what_another_robot_changes(seed):
    """Of bodies, joints, rotors and stages taken for others, at every level: to rounding."""
    robot, rng = chains.random_chain(seed), np.random.default_rng(seed)
    states = sample_states(robot, 3, seed)
    table = ChangeTable(SimpleNamespace(robot=robot, states=states))
    changed = [each.put(each.value + each.step / 2) for each in table.numbers]
    for level in require_items(RIGID):
        mistakes = list(list_frame_mistakes(robot, level))
        robots = [*changed, *(each.robot for each in mistakes)]
        together, base = table.compute_changes(robots, level), table.compute_base(level)
        for number in require_items(rng.choice(len(robots), 40, replace=False)):
            exact = AnalyticRobot(robots[number], level).terms(*states[:2])
            for change, right, other in require_items(zip(together, base, exact, strict=True)):
                np.testing.assert_allclose(right + change[number], other, rtol=1e-9, atol=1e-10)


def test_a_factor_between_units_is_the_number_that_its_words_say():
    """Twice: as a number before `times as large` or `of it`, and by the units named behind."""
    words_by_factor = [
        *UNITS.items(),
        *(each for table in UNITS_OF.values() for each in table.items()),
    ]
    for factor, words in require_items(words_by_factor):
        said = re.split(" times as large| of it", words)[0].replace("2 pi", "2*pi")
        assert float(sp.sympify(said)) == pytest.approx(factor, rel=1e-12), words
    meant = {"degrees taken for radians": np.pi / 180, "turns taken for radians": 0.5 / np.pi}
    for text, factor in require_items(meant.items()):
        assert any(text in words for own, words in UNITS.items() if own == pytest.approx(factor))
