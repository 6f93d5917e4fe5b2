"""Records damaged at random: refused, or something moved; never a crash, never a pass."""

import copy
import json
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from crosscheck.baseline.file import read_baseline
from crosscheck.baseline.record import Baseline
from crosscheck.run import CrossCheck
from tests.baselines.short import RENEW
from tests.draws import DRAWS, fresh_seed
from tests.processes import Command
from tests.tool.test_bad_input import assert_one_line

pytestmark = pytest.mark.campaign
CHECK = ("baseline", "check", "--quick")
Place = tuple[str | int, ...]
STRANGE: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 2**70, 1e300, -1e-300, float("nan"), float("inf")),
    *("", "agree", "measured", "1.0", "\x1b[2J\ud800", [], {}, [[]], {"tolerance": 1.0}),
)


def _places(value: Any, at: Place = ()) -> Iterator[Place]:
    """Every place in a tree of JSON values but its root."""
    if at:
        yield at
    for key, item in _inner(value):
        yield from _places(item, (*at, key))


def _inner(value: Any) -> list[tuple[str | int, Any]]:
    if isinstance(value, dict):
        return [*value.items()]
    return [*enumerate(value)] if isinstance(value, list) else []


def _at(data: Any, place: Place) -> Any:
    for key in place:
        data = data[key]
    return data


def _damage(data: dict[str, Any], places: list[Place], draw: random.Random) -> Place:
    """Delete, replace, scale or swap something, or give it another name; where."""
    place = draw.choice(places)
    holder, key = _at(data, place[:-1]), place[-1]
    value = holder[key]
    what = draw.choice(("delete", "replace", "scale", "swap", "rename"))
    if what == "delete":
        del holder[key]
    elif what == "scale" and isinstance(value, float):
        holder[key] = value * draw.choice((-1.0, 1 + 1e-9, 1.01, 10.0, 1e30))
    elif what == "swap":
        other = draw.choice([*holder] if isinstance(holder, dict) else range(len(holder)))
        holder[key], holder[other] = holder[other], value
    elif what == "rename" and isinstance(holder, dict):
        name = draw.choice((f"{key}x", "planet", "joint", "theta", "F_sp", "\x1b[2J\ud800"))
        holder[name] = holder.pop(key)
    else:
        holder[key] = draw.choice(STRANGE)
    return place


def _damaged(text: str, seed: int, count: int) -> Iterator[tuple[Place, dict[str, Any]]]:
    """So many records with one thing damaged."""
    draw, whole = random.Random(seed), json.loads(text)
    content = json.dumps(whole, sort_keys=True)
    places = list(_places(whole))
    for _ in range(count):
        data = copy.deepcopy(whole)
        place = _damage(data, places, draw)
        while json.dumps(data, sort_keys=True) == content:
            place = _damage(data, places, draw)
        yield place, data


@pytest.fixture
def seed(capsys: pytest.CaptureFixture[str]) -> int:
    """Another one in every run, which a failure shows among the arguments of its test."""
    number = fresh_seed()
    capsys.readouterr()
    return number


def test_a_damaged_record_is_refused_or_seen(command, recorded, result, seed):
    text = recorded.read_text(encoding="utf-8")
    for place, data in _damaged(text, seed, DRAWS):
        recorded.write_text(json.dumps(data), encoding="utf-8")
        _require_refused_or_seen(command, recorded, result, text, place)


def test_damaged_bytes_are_refused_or_seen(command, recorded, result, seed):
    """A byte changed, a piece lost or twice."""
    draw, whole = random.Random(seed), recorded.read_bytes()
    for _ in range(DRAWS):
        start = draw.randrange(len(whole))
        end = min(len(whole), start + draw.choice((0, 1, 40, 4000)))
        piece = draw.choice((b"", bytes([draw.randrange(256)]), 2 * whole[start:end]))
        recorded.write_bytes(whole[:start] + piece + whole[end:])
        place = start, end, str(piece)
        _require_refused_or_seen(command, recorded, result, whole.decode(), place)


def _require_refused_or_seen(
    command: Command, recorded: Path, result: CrossCheck, whole: str, place: Place
) -> None:
    """Refused in one short line, seen as a change, or all that is compared is as it was."""
    answer = command(*CHECK, result=result)
    assert answer.code in (0, 1, 2), place
    if answer.code == 2:
        assert_one_line(answer)
    if answer.code == 0:
        said = read_baseline(recorded, result.request, RENEW)
        assert _is_the_same(dict(_leaves(json.loads(whole))), said), place


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
            return abs(value - was) <= _at(data, place[: place.index(name)])["tolerance"]
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
