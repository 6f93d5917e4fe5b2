"""Two errors at once in a robot's equations: both are named, and no pair is where there is none."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.bench_robot_time import try_wrong
from crosscheck.models.robot.file import load_robot
from crosscheck.trial.changes.arms import steps
from crosscheck.trial.changes.pairs import PairSearch, Single, rank_pairs
from crosscheck.trial.changes.search import Cause, CauseSearch


def test_no_pair_explains_a_wave_in_every_part():
    found = try_wrong(load_robot("puma560"), ("mass_matrix", "bias", "gravity")).diagnosis
    assert not [each for each in (*found.explanations, *found.notes) if "two changes" in each]


def test_pairs_of_rows_by_one_matrix():
    """Rows 1 and 3 once, or row 1 and three times the free row 4; and none of one owner."""
    rng = np.random.default_rng(3)
    rows, owners = rng.normal(size=(6, 20)), np.arange(6)
    is_free = np.array([False, False, False, False, True, True])
    pairs = rank_pairs(rows, is_free, rows[1] + rows[3], owners)
    assert [each[:2] for each in pairs] == [(1, 3)]
    ((first, second, times),) = rank_pairs(rows, is_free, rows[1] + 3 * rows[4], owners)
    assert (first, second, times) == (1, 4, pytest.approx(3.0))
    assert rank_pairs(rows, is_free, 2 * rows[4] + 3 * rows[5], owners) == []
    owners[3] = owners[1]
    assert rank_pairs(rows, is_free, rows[1] + rows[3], owners) == []


def test_two_values_of_one_number_have_one_owner():
    mass = SimpleNamespace(value=2.0)
    values = [Single("", np.ones(3), number=mass, value=value) for value in (0.0, 4.0)]
    singles = [*values, Single("", np.ones(3))]
    twice, none, other = PairSearch.owners.fget(SimpleNamespace(singles=singles))
    assert twice == none != other


def test_of_pairs_of_changes_those_of_two_usual_ones_come_first():
    pairs = SimpleNamespace(find_pairs=lambda _: {"a and b": False, "c and d": True}.items())
    causes = CauseSearch.find_pair_causes(pairs)
    assert [cause.usual for cause in causes] == [True, False]


def test_a_number_of_an_arms_file_left_out_is_named_once(monkeypatch):
    causes = [Cause("link 2: left out", True), Cause("link 2: mass, 0 kg", True, path="mass_kg")]
    monkeypatch.setattr(steps, "find_explanations", lambda *_: ("links", causes))
    assert steps.find_changes({}, [], lambda _: []).words == ["link 2: mass, 0 kg"]
