"""Records damaged at random: refused, or something moved; never a crash, never a pass."""

import json
import random
from collections.abc import Iterator
from functools import reduce
from operator import getitem
from typing import Any

import pytest

from crosscheck.baseline.file import read_baseline
from crosscheck.baseline.record import Baseline
from tests.baselines.short import RENEW
from tests.draws import DRAWS, fresh_seed
from tests.loops import require_items
from tests.tool.damage import damage_text
from tests.tool.test_bad_input import assert_one_line

pytestmark = pytest.mark.campaign
CHECK = ("baseline", "check", "--quick")
Place = tuple[str | int, ...]


@pytest.fixture
def seed(capsys: pytest.CaptureFixture[str]) -> int:
    """Another one in every run, which a failure shows among the arguments of its test."""
    number = fresh_seed()
    capsys.readouterr()
    return number


def test_a_damaged_record_is_refused_or_seen(command, recorded, result, seed):
    """Refused in one short line, seen as a change, or all that is compared is as it was."""
    whole = recorded.read_bytes()
    for number in require_items(range(2 * DRAWS)):
        recorded.write_bytes(damage_text(whole, random.Random(f"{seed} {number}")))
        answer = command(*CHECK, result=result)
        assert answer.code in (0, 1, 2), number
        if answer.code == 2:
            assert_one_line(answer)
        if answer.code == 0:
            record = read_baseline(recorded, result.request, RENEW)
            assert _is_the_same(dict(_leaves(json.loads(whole))), record), number


def _is_the_same(whole: dict[Place, Any], record: Baseline) -> bool:
    """Whether a record says what the whole one does, to its tolerances."""
    data = record.model_dump(mode="json")
    now = dict(_leaves(data))
    if whole.keys() != now.keys():
        return False
    changed = [place for place, value in now.items() if value != whole[place]]
    return all(_within(data, place, now[place], whole[place]) for place in changed)


def _within(data: dict[str, Any], place: Place, value: Any, was: Any) -> bool:
    for name in ("rows", "measured"):
        if name in place:
            record = reduce(getitem, place[: place.index(name)], data)
            return bool(abs(value - was) <= record["tolerance"])
    return False


NOT_COMPARED = {"basis", "uncertainty", "tolerance", "widest", "said", "project_version"}


def _leaves(value: Any, at: Place = ()) -> Iterator[tuple[Place, Any]]:
    """What is compared: all but reasons, times of extremes, and where the record comes from.

    A tolerance counts where it is held against today's, and the widest is today's: a hundredfold
    tolerance is refused.
    """
    if isinstance(value, dict):
        for key, item in value.items():
            if key not in NOT_COMPARED and (at[:1] != ("provenance",) or key in ("arm", "quick")):
                yield from _leaves(item, (*at, key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            if "extremes" not in at or at[-2:-1] != ("rows",) or index not in (2, 4):
                yield from _leaves(item, (*at, index))
    else:
        yield at, value
