"""Record files: names, and what is refused in one line before anything is run."""

import json
import re
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.baseline.file import (
    LARGEST_BYTES,
    baseline_path,
    read_baseline,
    require_replaceable,
    write_baseline,
)
from crosscheck.baseline.reduction import make_baseline
from crosscheck.checks.records import BY_PLANET
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Switches
from crosscheck.models.loading import load_scenario
from crosscheck.planning.plan import CrossCheckRequest
from tests.baselines.short import ANALYTIC, RENEW, Change, edited, put, quick
from tests.obstacles import OBSTACLES

# Names


def _file(arm: Arm, name: str) -> str:
    return baseline_path(Path(), quick(arm.model_copy(update={"name": name}))).name


@pytest.mark.parametrize("name", ["paper-labelled", "a_b.c-1", "4-joint"])
def test_a_plain_name_is_the_files(labelled, name):
    assert _file(labelled, name) == f"{name}-quick.json"


def test_two_names_never_share_a_file(labelled):
    """Not where case is ignored either, nor where one is named as the file of another."""
    names = [
        *("a b", "a-b", "a_b", "a/b", "A-B", "A-b", "ä", "ö", "手", "腕"),
        *("a  b", " a b", ".", ".."),
    ]
    names.append(_file(labelled, names[0]).removesuffix("-quick.json"))
    files = [_file(labelled, name) for name in names]
    assert len({file.casefold() for file in files}) == len(names)
    assert all(file.isascii() and "/" not in file and len(file) < 150 for file in files)


def test_quick_full_and_own_experiments_lie_apart(labelled):
    own = load_scenario("pd"), load_scenario("back-and-forth")
    plans = {
        "paper-labelled-quick.json": CrossCheckRequest(labelled, quick=True),
        "paper-labelled-full.json": CrossCheckRequest(labelled),
        "paper-labelled+pd+back-and-forth-quick.json": CrossCheckRequest(labelled, True, 0, own),
    }
    assert [baseline_path(Path(), wanted).name for wanted in plans.values()] == list(plans)


def test_another_arms_record_is_not_replaced(recorded, labelled):
    with pytest.raises(InputError, match=r"name = 'paper-labelled': another arm than 'another'"):
        require_replaceable(recorded, "another")
    require_replaceable(recorded, labelled.name)
    for damaged in ("", "{}", '{"provenance": []}', '{"provenance": {"arm": {"name": 7}}}'):
        recorded.write_text(damaged, encoding="utf-8")
        require_replaceable(recorded, "another")


# Refusals. Every change below renews the digest: what is refused is refused for what it says.


RUN = ("runs", str(ANALYTIC))
PLACES = {"run": RUN, **{of: (*RUN, *of.split()) for of in ("sampled theta", "extremes F_sp")}}
ROWS = tomllib.loads(Path(__file__).with_name("refused.toml").read_text(encoding="utf-8"))


def _set(value: object, begins: str, *place: str | int) -> Change:
    """Put a value somewhere; PLACES has what a place may begin with."""
    return put(value, *PLACES.get(begins, (begins,)), *place)


def _other_arm(data: dict[str, Any]) -> None:
    data["provenance"]["arm"]["joints"][1]["sun_mesh"]["backlash_m"] = 6e-5
    data["provenance"]["arm_sha256"] = 64 * "a"


def _renamed(old: str, new: str) -> Change:
    def change(data: dict[str, Any]) -> None:
        tables = data["runs"][str(ANALYTIC)]["sampled"]
        tables[new] = tables.pop(old)

    return change


def _reverse_joints(data: dict[str, Any]) -> None:
    """In all tables of teeth alike."""
    run = data["runs"][str(ANALYTIC)]
    for name, table in (run["sampled"] | run["extremes"]).items():
        if name in BY_PLANET:
            table["joints"].reverse()
            if name in run["extremes"]:
                table["rows"].reverse()


ROW = "sampled theta", "rows"
REFUSED: dict[str, Change] = {
    **{name: _set(value, *place) for name, (value, place) in ROWS.items()},
    "another arm": _other_arm,
    "joints backwards": _reverse_joints,
    "no version": lambda data: data.pop("project_version"),
    "a known check that is none": _set({"said": "", "number": None}, "known", "x"),
    "a sampled planet": _renamed("theta", "planet"),
    "a sampled joint": _renamed("theta", "joint"),
    "a sampled extreme": _renamed("theta", "F_sp"),
    "an integer beyond all floats": _set(10**400, *ROW, 3, 1),
    "nothing for a number": _set(None, *ROW, 3, 1),
    "half a run": _set(lambda rows: rows[:10], *ROW),
    "a joint less": _set(lambda rows: [row[:2] for row in rows], *ROW),
    "a joint less at the extremes": _set(lambda rows: rows[:-1], "extremes F_sp", "rows"),
    "joints in another order": _set(lambda rows: rows[::-1], "extremes F_sp", "rows"),
    "six columns": _set(lambda rows: [[*row, 0.0] for row in rows], "extremes F_sp", "rows"),
    "missing field": lambda data: data.pop("checks"),
    "a name without end": _set("x", "checks", 9999 * "n"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_a_record_of_something_else_is_refused(
    recorded, labelled, what, snapshot: SnapshotAssertion
):
    edited(recorded, REFUSED[what])
    line = _refusal(recorded, labelled).removeprefix(str(recorded))
    line = re.sub(r"(\w)\1{20,}", r"\1\1", line)  # as many as the folder's name leaves room for
    assert re.sub(r"\d+\.\d+e-\d+", "#", line) == snapshot


def _refusal(path: Path, arm: Arm) -> str:
    """The one line that refuses a record."""
    with pytest.raises(InputError) as refused:
        read_baseline(path, quick(arm), RENEW)
    said = str(refused.value)
    assert said.isprintable()
    assert said.startswith(str(path))
    assert said.endswith(RENEW)
    assert len(said) - len(str(path)) < 400
    return said


def test_layout_is_not_content(recorded, result):
    data = json.loads(recorded.read_text(encoding="utf-8"))
    backwards = dict(reversed(data.items()))
    recorded.write_text(json.dumps(backwards, indent=7), encoding="utf-8")
    assert read_baseline(recorded, result.request, RENEW) == make_baseline(result)


@pytest.mark.parametrize("old", ["-quick", "-full"])
def test_a_copy_under_the_other_plans_name_is_refused(result, tmp_path, old):
    is_quick = old == "-quick"
    baseline = make_baseline(result)
    provenance = baseline.provenance.model_copy(update={"quick": is_quick})
    write_baseline(tmp_path / "x.json", baseline.model_copy(update={"provenance": provenance}))
    read_baseline(tmp_path / "x.json", CrossCheckRequest(result.mechanism, is_quick), RENEW)
    with pytest.raises(InputError, match=f"{'full' if is_quick else '--quick'} record is needed"):
        read_baseline(tmp_path / "x.json", CrossCheckRequest(result.mechanism, not is_quick), RENEW)


@pytest.mark.parametrize(
    ("field", "other", "said"),
    [
        ("chosen", Switches(damping="contact"), "switches"),
        ("scenarios", (load_scenario("back-and-forth"),), "scenarios"),
    ],
)
def test_a_record_of_other_laws_or_experiments_is_refused(result, recorded, field, other, said):
    with pytest.raises(InputError, match=f"made with other {said} than these"):
        read_baseline(recorded, replace(result.request, **{field: other}), RENEW)


GARBLED = (
    *("", "{", "[]", "null", "NaN", '{"schema_version": 1', "\ufeff{}", "[" * 100_000),
    *(
        '{"a":' * 100_000,
        "1" * 5000,
        '{"schema_version": ' + "1" * 5000,
        "<<<<<<< HEAD",
        "\udcff\udcfe\0",
    ),
)


@pytest.mark.parametrize("text", GARBLED)
def test_a_truncated_or_garbled_record_is_refused(recorded, labelled, text):
    recorded.write_text(text, "utf-8", "surrogateescape")
    _refusal(recorded, labelled)


@pytest.mark.parametrize("field", ["runs", "extra", "seed"])
def test_a_bottomless_value_is_refused(recorded, labelled, field):
    """As deep as the parser goes: showing it must not go deeper."""
    for depth in range(880, 1000, 7):
        deep: Any = json.loads(recorded.read_text(encoding="utf-8"))
        text = json.dumps(deep | {field: "DEEP"}).replace('"DEEP"', "[" * depth + "]" * depth)
        recorded.write_text(text, encoding="utf-8")
        _refusal(recorded, labelled)
        recorded.write_text(json.dumps(deep), encoding="utf-8")


def test_a_key_given_twice_is_refused(recorded, labelled):
    text = recorded.read_text(encoding="utf-8").replace('"theta":', '"theta": {}, "theta":', 1)
    recorded.write_text(text, encoding="utf-8")
    assert "theta = {" in _refusal(recorded, labelled)


def test_not_a_number_is_refused(recorded, labelled):
    text = re.sub(r'"tolerance": [0-9.e-]+', '"tolerance": NaN', recorded.read_text(), count=1)
    recorded.write_text(text, encoding="utf-8")
    assert "tolerance = nan: " in _refusal(recorded, labelled)


def _huge(path: Path) -> None:
    with path.open("wb") as stream:
        stream.truncate(10 * LARGEST_BYTES)


@pytest.mark.parametrize("what", ["folder", "pipe", "loop", "device", "huge"])
def test_what_is_no_file_is_refused_at_once(tmp_path, labelled, what):
    path = tmp_path / "paper-labelled-quick.json"
    {**OBSTACLES, "huge": _huge}[what](path)
    for attempt in (
        lambda: read_baseline(path, quick(labelled), RENEW),
        lambda: require_replaceable(path, labelled.name),
    ):
        with pytest.raises(InputError, match=r"not a record|cannot be read") as refused:
            attempt()
        assert str(refused.value).isprintable()


def test_an_interrupted_write_leaves_the_old_record(result, recorded, monkeypatch):
    before = recorded.read_bytes()

    def full(*paths: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("crosscheck.output.os.replace", full)
    with pytest.raises(InputError, match="No space left on device"):
        write_baseline(recorded, make_baseline(result).model_copy(update={"checks": {}}))
    assert recorded.read_bytes() == before
    assert list(recorded.parent.iterdir()) == [recorded]
