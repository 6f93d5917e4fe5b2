"""Tables that cannot be judged: one line with file, row, column and what is allowed."""

import io
import re
import struct
import zlib
from collections import defaultdict
from itertools import product
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import h5py
import numpy as np
import pytest
import scipy.io
from syrupy.assertion import SnapshotAssertion

from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm
from crosscheck.trial.input.equations import Coordinates, load_coordinates
from crosscheck.trial.input.loading import load_equations
from crosscheck.trial.tables.answer_files import TableColumns, _precision, read_answers
from crosscheck.trial.tables.answers import (
    _require_same_states,
    _values,
    build_table_equations,
    read_trial_answers,
)
from crosscheck.trial.tables.folder import (
    encode_mat_file,
    format_arm_toml,
    render_probe_files,
    render_request_files,
)
from crosscheck.trial.tables.state_requests import TableTrial, collect_state_request
from tests.tool.supplied import TWO_LINK
from tests.tool.test_bad_input import assert_one_line
from tests.trial.other_tools.tables import judge_table, sheets_of, write_csv

ROWS = 40
GOOD = ["row,force_1,force_2", *(f"{k},{k / 7!r},{k / 11!r}" for k in range(1, ROWS))]


def changed(line: int, text: str) -> str:
    return "\n".join([*GOOD[:line], text, *GOOD[line + 1 :]])


CSV = {
    "nothing": "",
    "no header": "1,2,3\n4,5,6",
    "only a header": GOOD[0],
    "no answers": "row\n1",
    "no row": changed(0, "number,force_1,force_2"),
    "semicolons": changed(0, GOOD[0].replace(",", ";")),
    "tabs": changed(0, GOOD[0].replace(",", "\t")),
    "transposed": "row,-0.25,2e3,3\nforce_1,5,6,7",
    "an unknown column": changed(0, "row,force_1,force_3"),
    "a column twice": changed(0, "row,force_1,force_1"),
    "half a vector": "row,force_1\n1,2",
    "a short line": changed(3, "3,1.5"),
    "a word": changed(3, "\n3, ,much"),
    "a row and a half": changed(3, "3.5,1,2"),
    "row 0": changed(3, "0,1,2"),
    "no number of a row": changed(3, ",1,2"),
    "a row twice": changed(3, "1,1,2"),
    "few digits": "\n".join([GOOD[0], *(f"{k},{k / 7:.5g},{k / 11:.5g}" for k in range(1, ROWS))]),
    "inverse dynamics of other rows": "row,inverse_dynamics_1,inverse_dynamics_2\n1,0.5,0.5",
    "rows left out": "\n".join(GOOD),
    "an infinite number": changed(3, "3,inf,1"),
    "a NaN": changed(3, "3,nan,1"),
    "rows beyond": changed(3, "99999,1,2"),
    "other states": "row,q_theta_1_rad,force_1,force_2\n1,0.5,3,4",
}


def version_7(**variables: np.ndarray) -> bytes:
    file = io.BytesIO()
    with h5py.File(file, "w") as made:
        for name, values in variables.items():
            made[name] = values.T  # as MATLAB has them there
    return file.getvalue()


def bomb() -> bytes:
    """A MAT v5 file of a few kB whose one array says that it has 8 GB."""
    count = 10**9
    flags = struct.pack("<IIII", 6, 8, 6, 0)
    dimensions = struct.pack("<IIii", 5, 8, count, 1)
    name = struct.pack("<II8s", 1, 3, b"row")
    data = struct.pack("<II", 9, 0) + bytes(100_000)
    matrix = struct.pack("<II", 14, 2**31 - 1) + flags + dimensions + name + data
    packed = zlib.compress(matrix)
    return encode_mat_file({})[:128] + struct.pack("<II", 15, len(packed)) + packed


NUMBERS = np.random.default_rng(1).uniform(size=(ROWS, 2))
ROW = np.arange(1.0, ROWS + 1)[:, None]
MATS = {
    "no MAT file": b"row, force\n" * 100,
    "cut short": encode_mat_file({"row": ROW, "force": NUMBERS})[:600],
    "no row": encode_mat_file({"force": NUMBERS}),
    "text": encode_mat_file({"row": ROW, "force": np.array(["a"])}),
    "complex": encode_mat_file({"row": ROW, "force": 1j * NUMBERS}),
    "transposed": encode_mat_file({"row": ROW, "force": NUMBERS.T}),
    "another shape": encode_mat_file({"row": ROW, "M": ROW}),
    "transposed, v7.3": version_7(row=ROW, force=NUMBERS.T),
    "HDF5 that is none": version_7(row=ROW, force=NUMBERS)[:700],
    "a bomb": bomb(),
}
FILES = {
    **{f"{name}.csv": text.encode() for name, text in CSV.items()},
    **{f"{name}.mat": content for name, content in MATS.items()},
}


@pytest.mark.usefixtures("asked_once")
@pytest.mark.parametrize("name", FILES)
def test_answers_that_cannot_be_judged_are_one_line(
    name, tmp_path, monkeypatch, snapshot: SnapshotAssertion
):
    monkeypatch.chdir(tmp_path)
    file = Path(name)
    file.write_bytes(FILES[name])
    with pytest.raises(InputError) as error:
        build_table_equations(
            read_trial_answers(TableTrial(load_arm("paper-labelled"), quick=True), [file])
        )
    line, _, _ = str(error.value).partition("Error: ")  # in the words of a library
    assert line == snapshot


@pytest.mark.parametrize("digits", [8, 12])
def test_precision_is_half_of_the_last_digit_of_a_number_that_begins_with_one(digits):
    exact = 1 + np.random.default_rng(0).uniform(0, 1e-3, 500)
    written = np.array([float(f"{value:.{digits - 1}f}") for value in exact])
    found = _precision("file", np.append(np.arange(-3e3, -1e3), written), 6)  # a sample of all
    assert found == pytest.approx(0.5 * 10.0 ** (1 - digits))
    assert 0.9 * found < np.abs(written - exact).max() <= found * (1 + 1e-3)


def test_single_precision_shows_in_twenty_numbers_and_has_seven_digits():
    numbers = np.float32(1 / np.arange(3.0, 43.0, 2)).astype(float)
    assert _precision("file", numbers[:19], 7) == 0 < _precision("file", numbers, 7)
    with pytest.raises(InputError, match="single precision; 8 digits are needed"):
        _precision("file", numbers, 8)


def test_states_are_the_same_to_single_precision_of_their_largest_number():
    right = np.array([[0.5], [2.0]])
    sheet: Any = SimpleNamespace(
        columns=defaultdict(list, x=["q"]), arguments={"x": right}, first=1, count=2
    )
    file: Any = SimpleNamespace(rows=np.array([1, 2]), where="a.csv")
    file.state_columns = {"q": right[:, 0] + [0.98 * 2e-4, 0.0]}
    _require_same_states(file, sheet)
    file.state_columns = {"q": right[:, 0] + [1.02 * 2e-4, 0.0]}
    with pytest.raises(InputError, match=r"500204: answers to other states: must be 0\.5"):
        _require_same_states(file, sheet)


def test_a_single_row_that_is_missing_is_named_with_the_file_that_has_such_rows():
    asked = SimpleNamespace(first=1, count=3, shape=lambda part: (1,), needed={"force": [True] * 3})
    near = SimpleNamespace(where="a.csv", rows=np.array([1, 2, 3]))
    near.answers = {"force": np.array([[1.0], [np.nan], [3.0]])}
    far = SimpleNamespace(where="b.csv", rows=np.array([9]), answers={"force": np.ones((1, 1))})
    answers: Any = SimpleNamespace(files=(SimpleNamespace(answers={}), near, far))
    with pytest.raises(InputError, match=r"a\.csv: row 2, force: is missing"):
        _values(answers, cast(Any, asked), "force")


@pytest.mark.parametrize("number", [0, -1])
def test_states_of_every_round_are_compared(number, tmp_path):
    """Also those of other arms, which come in the second round."""
    table, file = TableTrial(load_arm("paper-labelled"), quick=True), tmp_path / "mine.py"
    file.write_text(TWO_LINK, encoding="utf-8")
    equations = load_equations(f"{file}:two_link", table.mechanism, None)
    sheets = sheets_of(table, equations, probes=True)
    states = {each.first + k: x for each, _ in sheets for k, x in enumerate(each.arguments["x"])}
    asked, _ = sheets[number]
    for row in range(asked.first, asked.first + asked.count):
        states[row] = states[row] + 1.0
    answered = write_csv(tmp_path / "answers.csv", sheets)
    header, *lines = answered.read_text(encoding="utf-8").splitlines()
    rows = (",".join([line, *map(str, states[int(line.partition(",")[0])])]) for line in lines)
    text = "\n".join([",".join([header, *asked.columns["x"]]), *rows])
    answered.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="answers to other states"):
        judge_table(table, answered)


@pytest.mark.parametrize(("force", "acceleration"), [(8, 12), (12, 8), (17, 8)])
def test_the_part_with_the_fewest_digits_tells_the_precision(force, acceleration, tmp_path):
    values = 1 + np.random.default_rng(0).uniform(0, 1e-3, (500, 2))
    rows = [f"{k},{a:.{force - 1}f},{b:.{acceleration - 1}f}" for k, (a, b) in enumerate(values, 1)]
    file = tmp_path / "answers.csv"
    file.write_text("\n".join(["row, force_1,acceleration_1", *rows]))
    read = read_answers(file, TableColumns(1, TableTrial.parts, {}, 7))
    assert read.precision == pytest.approx(0.5e-7)


@pytest.mark.usefixtures("asked_once")
def test_parts_may_be_answered_in_files_of_their_own(tmp_path):
    table, parts = TableTrial(load_arm("paper-labelled"), quick=True), ("force", "acceleration")
    for part in parts:
        (tmp_path / part).write_text(f"row,{part}_1,{part}_2\n1,2,3")
    assert len(read_trial_answers(table, [tmp_path / part for part in parts]).parts) == 2


@pytest.mark.parametrize("shape", ["matrices first", "matrices last", "flat"])
def test_every_form_of_a_matrix_is_read_the_same(shape, tmp_path):
    M = np.random.default_rng(2).uniform(size=(ROWS, 2, 2))
    given = {"matrices first": M, "matrices last": M.transpose(1, 2, 0), "flat": M.reshape(-1, 4)}
    file = tmp_path / "answers.mat"
    for content in (
        encode_mat_file({"row": ROW, "M": given[shape]}),
        version_7(row=ROW, M=given[shape]),
    ):
        file.write_bytes(content)
        read = read_answers(file, TableColumns(2, TableTrial.parts, {}, 7))
        assert (read.answers["mass_matrix"] == M.reshape(-1, 4)).all()
        assert read.precision == 0.0
    file.write_bytes(encode_mat_file({"row": ROW.T, "M": np.arange(4 * ROWS).reshape(-1, 4)}))
    read = read_answers(file, TableColumns(2, TableTrial.parts, {}, 1))
    assert read.answers["mass_matrix"][1, 0] == 4


def test_a_map_says_the_level(tmp_path):
    (tmp_path / "map.toml").write_text('level = "links"\n', encoding="utf-8")
    assert load_coordinates(tmp_path / "map.toml") == (Coordinates(), "links")


MAPS = {"an unknown key": "link = 'absolute'", "code": "names = ['os.system()', 'b']"}
COMMANDS: dict[str, tuple[str, dict[str, str]]] = {
    "a model beside": ("--answers a.csv m.py:model probe", {}),
    "ask and answers": ("--ask --answers a.csv --out ask", {}),
    "ask without a folder": ("--ask probe", {}),
    "after without ask": ("--after a.csv m.py:model", {}),
    "coordinates of a model": ("--coordinates c.toml m.py:model", {}),
    "a run": ("--answers a.csv --scenario pd", {}),
    "nothing": ("", {}),
    "no such file": ("--answers nonesuch.csv", {}),
    "no such map": ("--ask --out ask --coordinates no.toml", {}),
    **{
        f"map, {name}": ("--ask --coordinates map.toml --out ask", {"map.toml": text})
        for name, text in MAPS.items()
    },
}


@pytest.mark.parametrize("case", COMMANDS)
def test_words_and_maps_that_cannot_be_used_are_one_line(refuse, case, snapshot: SnapshotAssertion):
    words, files = COMMANDS[case]
    assert refuse(f"trial {words}", files) == snapshot


def test_ask_writes_over_nothing(crosscheck, tmp_path):
    (tmp_path / "answers.m").write_text("mine", encoding="utf-8")
    answer = crosscheck("trial", "--ask", "--quick", "--out", tmp_path)
    assert_one_line(answer, "answers.m: exists already; name another folder")
    assert [path.name for path in tmp_path.iterdir()] == ["answers.m"]


def test_each_arm_of_the_second_round_has_templates_of_its_own():
    """None writes over another's answers, and the README names all files, the first ones too."""
    table = TableTrial(load_arm("paper-labelled"), quick=True)
    asked = collect_state_request(table)
    files = render_probe_files(table, [asked, asked], "my.toml", [Path("a.mat")], Path("again"))
    for number, suffix in product((1, 2), (".m", ".c", ".jl", ".mos")):
        text = str(files[f"answers_{number}{suffix}"])
        assert set(re.findall(r"probe-\d", text)) == {f"probe-{number}"}
        assert set(re.findall(r"answers\w*(?=\.)", text)) == {f"answers_{number}"}
    given = "--answers a.mat --answers again/answers_1.mat --answers again/answers_2.mat my.toml\n"
    assert str(files["README.md"]).endswith(f"crosscheck trial {given}")


def test_the_commands_of_a_readme_hold_where_ask_ran():
    table = TableTrial(load_arm("paper-labelled"), quick=True)
    asked = collect_state_request(table)
    files = render_request_files(table, [asked], "../my.toml", Path("my folder"))
    assert re.findall("crosscheck trial (.*)", str(files["README.md"]))[-2:] == [
        "--answers 'my folder/answers.csv' ../my.toml",
        "--ask ../my.toml --after 'my folder/answers.csv' --out ask-2",
    ]
    assert "write `answers.mat`" in str(files["README.md"])


@pytest.mark.parametrize("name", ["paper-labelled", "three-unlike", "direct-between"])
def test_arm_is_read_back_as_it_was(name, tmp_path):
    file = tmp_path / "arm.toml"
    file.write_text(format_arm_toml(load_arm(name)), encoding="utf-8")
    assert load_arm(str(file)) == load_arm(name)


def test_both_files_of_states_say_the_same():
    table = TableTrial(load_arm("paper-labelled"), quick=True)
    asked = collect_state_request(table)
    files = render_request_files(table, [asked], "", Path())
    text, content = files["states.csv"], files["states.mat"]
    assert isinstance(text, str)
    assert isinstance(content, bytes)
    rows = np.genfromtxt(io.StringIO(text), delimiter=",", skip_header=1)
    read = scipy.io.loadmat(io.BytesIO(content))
    assert (rows[:, :8] == np.hstack([read[k] for k in ("row", "t", "q", "v", "torque")])).all()
    assert (rows[:, 8] == read["for_M"].ravel()).all()
