"""Bad studies: one line that says where, what and what is allowed; exit code 2; nothing written."""

from __future__ import annotations

from pathlib import Path

import pytest

import crosscheck
from crosscheck.sweeps import kept
from models.errors import InputError

STUDY = """\
schema_version = 1
name = "bad"
arm = "paper-labelled"
scenario = "pd"

[settings]
"scenario.duration_s" = 0.001

[samples]
count = 3

[[axes]]
path = "arm.joints.*.backlash_m"
kind = "uniform"
relative_tolerance = 0.1

[[axes]]
path = "arm.payload_mass_kg"
kind = "list"
values = [1.0, 2.0]

[[quantities]]
kind = "peak"
signal = "theta_ddot"
"""
PATH = 'path = "arm.joints.*.backlash_m"'
PAYLOAD = 'path = "arm.payload_mass_kg"'
VALUES = "values = [1.0, 2.0]"
UNIFORM = 'kind = "uniform"\nrelative_tolerance = 0.1'
PEAK = 'kind = "peak"\nsignal = "theta_ddot"'
GRID = 'kind = "grid"\nstart = 1e-5\nstop = 1e-4\ncount = '
BAD = {
    "path that is none": (PATH, 'path = "backlash"', "axes[0]", "'backlash'", "beginning with arm"),
    "unknown key in a path": (
        PATH,
        'path = "arm.joint.*.backlash_m"',
        "arm.joint",
        "no such entry",
    ),
    "unknown last key": (
        PAYLOAD,
        'path = "arm.payload_kg"',
        "arm.payload_kg",
        "did you mean payload_mass_kg?",
    ),
    "joint that is not there": (PATH, 'path = "arm.joints.7.backlash_m"', "index must be * or 0"),
    "empty axis": (VALUES, "values = []", "axes[1].values", "at least"),
    "grid of no points": (UNIFORM, GRID + "0", "axes[0].count", "must be 1 to 1e7"),
    "negative tolerance": (
        "relative_tolerance = 0.1",
        "relative_tolerance = -0.1",
        "axes[0].relative_tolerance = -0.1",
        "must be 0 to 1e15",
    ),
    "two tolerances": (
        "relative_tolerance = 0.1",
        "relative_tolerance = 0.1\ntolerance = 1e-6",
        "axes[0].tolerance",
        "either",
    ),
    "no samples": ("[samples]\ncount = 3", "", "samples", "is missing"),
    "value out of its range": (
        VALUES,
        "values = [1.0, -2.0]",
        "arm.payload_mass_kg",
        "-2.0",
        "1e-12 to 1e9 kg",
    ),
    "tolerance that leaves the range": (
        "relative_tolerance = 0.1",
        "tolerance = 1.0",
        "arm.joints.*.backlash_m",
        "0.1 m",
    ),
    "word for a number": (VALUES, 'values = ["heavy"]', "payload_mass_kg", "'heavy'", "number"),
    "about a value that is not given": (
        PATH,
        'path = "arm.joints.*.friction"',
        "arm.joints[0].friction",
        "give the centre",
    ),
    "two axes for one entry": (
        PAYLOAD,
        'path = "arm.joints.0.backlash_m"\nname = "other"',
        "arm.joints[0].backlash_m",
        "varied by backlash_m",
    ),
    "two axes of one name": (PAYLOAD, PAYLOAD + '\nname = "backlash_m"', "backlash_m", "taken"),
    "unknown kind of axis": (UNIFORM, 'kind = "random"', "axes[0]", "random", "latin_hypercube"),
    "unknown quantity": (PEAK, 'kind = "wobble"', "quantities[0]", "wobble", "peak_to_peak"),
    "unknown signal": ("theta_ddot", "theta_dddot", "quantities[0].signal", "theta_dddot"),
    "joint of a quantity": (PEAK, PEAK + "\njoint = 3", "theta_ddot_peak_joint3", "arm has 2"),
    "window after the end": (PEAK, PEAK + "\nwindow_s = [1.0, 2.0]", "window_s", "0.001 s"),
    "window that ends first": (PEAK, PEAK + "\nwindow_s = [0.5, 0.1]", "window_s", "end after"),
    "no target": (
        'scenario = "pd"',
        'scenario = "constant-torque"\n[[quantities]]\nkind = "final_error"\n',
        "theta_final_error",
        "PD drive",
    ),
    "two quantities of one name": (
        PEAK,
        f"{PEAK}\n[[quantities]]\n{PEAK}",
        "theta_ddot_peak",
        "name of its own",
    ),
    "unknown setting": ('"scenario.duration_s"', '"duration_s"', "settings", "duration_s"),
    "unknown arm": ("paper-labelled", "nobodys", "nobodys", "no such file"),
    "unknown key": ('name = "bad"', 'name = "bad"\nspot_check = 1', "did you mean spot_checks?"),
    "code": (
        PEAK,
        'kind = "user_function"\nfunction = "mine.py:f"\nreturns = { a = "m" }',
        "mine.py:f",
        "--run-code",
    ),
    "no name of a function": (
        PEAK,
        'kind = "user_function"\nfunction = 7\nreturns = { a = "m" }',
        "quantities[0].function",
        "string",
    ),
    "no units": (
        PEAK,
        'kind = "user_function"\nfunction = "mine.py:f"\nreturns = {}',
        "quantities[0].returns",
        "units by name",
    ),
    "another version": ("schema_version = 1", "schema_version = 2", "schema_version", "must be 1"),
}


def _file(folder: Path, old: str, new: str) -> Path:
    assert old in STUDY
    file = folder / "study.toml"
    file.write_text(STUDY.replace(old, new, 1), encoding="utf-8")
    return file


@pytest.mark.parametrize("case", BAD)
def test_one_line_says_what_is_wrong(case, command, tmp_path):
    old, new, *fragments = BAD[case]
    if case == "no target":  # its quantity stands after the settings
        old, new = 'scenario = "pd"', 'scenario = "constant-torque"'
    file = _file(tmp_path, old, new)
    if case == "no target":
        with file.open("a", encoding="utf-8") as text:
            text.write('[[quantities]]\nkind = "final_error"\n')
    code, out, err = command("sweep", file, "--out", tmp_path / "out.nc", "--jobs", 1)
    assert (code, out, err.count("\n")) == (2, "", 1), err
    for fragment in fragments:
        assert fragment in err
    assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]


def test_values_that_only_together_are_wrong_name_the_member(command, tmp_path):
    file = _file(tmp_path, PAYLOAD, 'path = "arm.links.0.com_m"')
    with file.open("a", encoding="utf-8") as text:
        text.write('[[axes]]\npath = "arm.links.0.length_m"\nkind = "list"\nvalues = [3.0, 1.5]\n')
    code, _, err = command("sweep", file, "--out", tmp_path / "out.nc", "--jobs", 1)
    assert (code, err.count("\n")) == (2, 1)
    # 2.0 is no place on a link of 1 m by itself
    assert "arm.links.0.com_m" in err


def test_more_members_than_the_disk_holds_are_refused_with_the_number(command, tmp_path):
    file = _file(tmp_path, "count = 3", "count = 10000000")
    text = file.read_text().replace(PEAK, 'kind = "trajectories"\nsignals = ["theta", "F_sp"]')
    file.write_text(text.replace('"scenario.duration_s" = 0.001', '"scenario.duration_s" = 3.0'))
    code, _, err = command("sweep", file, "--out", tmp_path / "out.nc", "--jobs", 1)
    assert (code, err.count("\n")) == (2, 1)
    assert "20,000,000 members" in err
    assert " GB" in err
    assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]


def test_room_is_what_the_disk_has(tmp_path):
    kept.require_room(tmp_path / "out.nc", 1000, 10)
    with pytest.raises(InputError, match="10 members"):
        kept.require_room(tmp_path / "out.nc", 10**18, 10)


def test_a_file_of_somebody_elses_is_left_alone(command, tmp_path):
    file, out = _file(tmp_path, PEAK, PEAK), tmp_path / "out.nc"
    out.write_text("mine")
    for more in ([], ["--resume"]):
        code, _, err = command("sweep", file, "--out", out, *more)
        assert (code, err.count("\n")) == (2, 1)
    folder = tmp_path / "other.nc.batches"
    folder.mkdir()
    (folder / "letter").write_text("mine")
    code, _, err = command("sweep", file, "--out", tmp_path / "other.nc")
    assert (code, err.count("\n")) == (2, 1)
    assert (out.read_text(), (folder / "letter").read_text()) == ("mine", "mine")
    code, _, err = command("sweep", file, "--out", file)
    assert code == 2
    assert file.read_text() == STUDY


FUNCTIONS = {
    "raises": ("def f(run):\n    return {'a': 1 / 0}\n", "ZeroDivisionError"),
    "other names": ("def f(run):\n    return {'b': 1.0}\n", "names a"),
    "no number": ("def f(run):\n    return {'a': 'high'}\n", "numbers"),
    "no function": ("g = 1\n", "no function f"),
    "no Python": ("def f(run:\n", "SyntaxError"),
}


@pytest.mark.parametrize("case", FUNCTIONS)
def test_a_function_that_cannot_be_used_is_named(case, command, tmp_path):
    code, fragment = FUNCTIONS[case]
    (tmp_path / "mine.py").write_text(code, encoding="utf-8")
    quantity = 'kind = "user_function"\nfunction = "mine.py:f"\nreturns = { a = "m" }'
    file = _file(tmp_path, PEAK, quantity)
    left, _, err = command("sweep", file, "--out", tmp_path / "out.nc", "--jobs", 1, "--run-code")
    assert (left, err.count("\n")) == (2, 1)
    assert "mine.py:f" in err
    assert fragment in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.py", "study.toml"]


def test_python_is_told_the_same():
    with pytest.raises(InputError, match="at least"):
        crosscheck.sweep(
            "paper-labelled",
            {"arm.payload_mass_kg": []},
            scenario="pd",
            measures=[{"kind": "peak"}],
        )
