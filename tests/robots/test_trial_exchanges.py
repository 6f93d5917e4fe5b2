"""Numbers and frames of a robot that are others: what each makes of its terms."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import sample_states
from crosscheck.models.robot.robot import RIGID
from crosscheck.trial.changes.mistakes import list_frame_mistakes
from crosscheck.trial.changes.numbers import UNITS, UNITS_OF
from crosscheck.trial.changes.table import ChangeTable
from tests.loops import require_items
from tests.robots import chains


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
