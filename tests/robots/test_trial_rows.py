"""A triangle of M that alone is filled is named as such."""

import numpy as np
import pytest

from tests.robots import two_link
from tests.robots.trials import run_robot_trial


@pytest.mark.parametrize(
    ("half", "is_triangle"), [(np.triu, True), (np.tril, True), (np.diag, False)]
)
def test_a_triangle_is_asked_for_only_where_the_other_one_is_right(half, is_triangle):
    def fill(q):
        return (
            half(half(np.array(two_link.mass_matrix(q))))
            if half is np.diag
            else half(np.array(two_link.mass_matrix(q)))
        )

    trial = run_robot_trial(two_link.right(mass_matrix=fill), two_link.robot())
    assert any("triangles alone" in each for each in trial.diagnosis.notes) == is_triangle
