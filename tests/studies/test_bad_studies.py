"""Bad studies: one line that says where, what and what is allowed; exit code 2; nothing written."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import crosscheck
from crosscheck.models.errors import InputError
from crosscheck.runner import patience
from crosscheck.studies.batches import kept
from crosscheck.studies.definition.files import read_study

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
path = "arm.joints.*.*_mesh.backlash_m"
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
PATH = 'path = "arm.joints.*.*_mesh.backlash_m"'
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
    "joint that is not there": (PATH, PATH.replace("*", "7", 1), "index must be * or 0"),
    "name that is not there": (PATH, PATH.replace("*_m", "*_t"), "*_tesh: no such entry"),
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
        "arm.joints.*.*_mesh.backlash_m",
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
        'path = "arm.joints.0.*_mesh.backlash_m"\nname = "other"',
        "arm.joints[0].sun_mesh.backlash_m",
        "varied by backlash_m",
    ),
    "two axes of one name": (PAYLOAD, PAYLOAD + '\nname = "backlash_m"', "backlash_m", "taken"),
    "unknown kind of axis": (UNIFORM, 'kind = "random"', "axes[0]", "random", "latin_hypercube"),
    "kind of 6000 digits": (UNIFORM, f"kind = 0x{'f' * 6000}", "too many digits"),
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
    **{
        f"quantity called {name}": (PEAK, f'{PEAK}\nname = "{name}"', name, "name of its own")
        for name in (
            *("start", "sample", "joint", "planet", "time", "checked", "checked_sample"),
            *("backlash_m", "backlash_m_entry", "diverged_s", "diverged_s_checked"),
        )
    },
    "quantity called as another's check": (
        PEAK,
        f'{PEAK}\nname = "a"\n[[quantities]]\n{PEAK}\nname = "a_difference"',
        "a_difference",
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
    "number beyond doubles": ("def f(run):\n    return {'a': 10**400}\n", "plain numbers"),
    "list": ("def f(run):\n    return [1.0]\n", "names a"),
    "more names": ("def f(run):\n    return {'a': 1.0, 'b': 2.0}\n", "names a"),
    "unprintable": (
        "class E(Exception):\n    def __str__(self):\n        raise self\n"
        "def f(run):\n    raise E\n",
        "raised E",
    ),
    "escapes": ("def f(run):\n    raise ValueError('a\\n\\x1b[31mb')\n", "ValueError"),
    "exit": ("def f(run):\n    raise SystemExit(0)\n", "SystemExit"),
    "exit while loading": ("raise SystemExit(0)\n", "SystemExit"),
    "no numbers at all": (
        "class N:\n    def __float__(self):\n        raise KeyError\n"
        "def f(run):\n    return {'a': N()}\n",
        "plain numbers",
    ),
    "no function": ("g = 1\n", "no function f"),
    "no Python": ("def f(run:\n", "SyntaxError"),
    "leaves": ("def f(run):\n    raise SystemExit(0)\n", "SystemExit: 0"),
    "leaves at import": ("raise SystemExit(0)\n", "SystemExit: 0"),
    "no Exception": ("def f(run):\n    raise type('Odd', (BaseException,), {})\n", "Odd"),
}
# What ends its process or never comes back, and what is said of it.
LOST = {
    "ends": ("import os\ndef f(run):\n    os._exit(0)\n", "exit code 0 in 3 attempts"),
    "ends at import": ("import os\nos._exit(0)\n", "exit code 0 in 3 attempts"),
    "hangs": ("import time\ndef f(run):\n    time.sleep(99)\n", "without any processor time"),
}


@pytest.mark.parametrize("case", FUNCTIONS)
def test_a_function_that_cannot_be_used_is_named(case, command, tmp_path):
    code, fragment = FUNCTIONS[case]
    (tmp_path / "mine.py").write_text(code, encoding="utf-8")
    quantity = 'kind = "user_function"\nfunction = "mine.py:f"\nreturns = { a = "m" }'
    file = _file(tmp_path, PEAK, quantity)
    left, _, err = command("sweep", file, "--out", tmp_path / "out.nc", "--jobs", 1, "--run-code")
    assert (left, err.count("\n")) == (2, 1)
    assert err[:-1].isprintable()
    assert "mine.py:f" in err
    assert fragment in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.py", "study.toml"]


@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.parametrize("case", LOST)
def test_a_function_that_does_not_come_back_ends_the_study(
    case, jobs, command, tmp_path, monkeypatch
):
    monkeypatch.setattr(patience, "IDLE_S", 2.0)
    monkeypatch.setattr(patience, "LEAST_S", 0.01)
    monkeypatch.setattr(patience, "LOOK_S", 0.1)
    code, fragment = LOST[case]
    (tmp_path / "mine.py").write_text(code, encoding="utf-8")
    quantity = 'kind = "user_function"\nfunction = "mine.py:f"\nreturns = { a = "m" }'
    file = _file(tmp_path, PEAK, quantity)
    left, _, err = command("sweep", file, "--out", tmp_path / "o.nc", "--jobs", jobs, "--run-code")
    assert (left, err.count("\n")) == (3, 1)
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


@pytest.mark.parametrize(
    "address",
    ["tls://127.0.0.1:1", "ucx://127.0.0.1:1", "ws://a:1", "inproc://x", "", "tcp://", "tcp://a:0"],
)
def test_a_scheduler_of_another_kind_is_one_line(command, tmp_path, address):
    file = _file(tmp_path, PEAK, PEAK)
    code, out, err = command("sweep", file, "--out", tmp_path / "o.nc", "--scheduler", address)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "--scheduler" in err
    assert "tcp://HOST:PORT" in err
    assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]


@pytest.mark.parametrize("what", ["folder", "pipe", "dangling", "loop"])
@pytest.mark.parametrize("place", ["study", "function", "out", "batches", "mark"])
def test_what_is_no_file_is_one_line(command, tmp_path, place, what):
    quantity = 'kind = "user_function"\nfunction = "mine.py:f"\nreturns = { a = "m" }'
    new = quantity if place == "function" else PEAK
    file = _file(tmp_path, PEAK, new)
    folder = tmp_path / "out.nc.batches"
    (tmp_path / "elsewhere").mkdir()
    if place == "mark":
        folder.mkdir()
    named = {
        "study": tmp_path / "other.toml",
        "function": tmp_path / "mine.py",
        "out": tmp_path / "out.nc",
        "batches": folder,
        "mark": folder / kept.MARK,
    }[place]
    if what == "folder":
        (named if place != "batches" else named / "a letter").mkdir(parents=True)
    elif what == "pipe":
        os.mkfifo(named)
    else:
        named.symlink_to({"dangling": "elsewhere/nowhere", "loop": named.name}[what])
    chosen = named if place == "study" else file
    arguments = ("sweep", chosen, "--out", tmp_path / "out.nc", "--jobs", 1, "--run-code")
    for more in ([], ["--resume"]):
        code, out, err = command(*arguments, *more)
        if place == "out" and what == "dangling":  # a link to a file that is going to be
            assert code == 0
            return
        assert (code, out, err.count("\n")) == (2, "", 1), err
    assert not list((tmp_path / "elsewhere").iterdir())


def test_batches_that_a_killed_study_left_beside_its_result_go(command, tmp_path):
    file, out = _file(tmp_path, PEAK, PEAK), tmp_path / "out.nc"
    assert command("sweep", file, "--out", out, "--jobs", 1)[0] == 0
    folder, digest = tmp_path / "out.nc.batches", read_study(file).digest
    for owner, left in ((digest, False), ("0" * 64, True)):
        folder.mkdir()
        (folder / kept.MARK).write_text(f"{owner}\n{'0' * 32}\n")
        (folder / f"{'0' * 32}.kept").write_text("half")
        code, said, err = command("sweep", file, "--out", out, "--jobs", 1, "--resume")
        assert (code, err) == (0, "")
        assert "is complete" in said
        assert folder.exists() == left


def test_what_the_mark_does_not_list_is_left_alone(command, tmp_path):
    file, out = _file(tmp_path, PEAK, PEAK), tmp_path / "out.nc"
    folder = tmp_path / "out.nc.batches"
    folder.mkdir()
    study = read_study(file)
    (folder / kept.MARK).write_text(f"{study.digest}\n{'0' * 32}\ntorn")
    letters = {f"{'1' * 32}.kept", f"{'2' * 32}.json", ".crosscheck-notes", "letter"}
    for name in letters:
        (folder / name).write_text("mine")
    (folder / f"{'0' * 32}.kept").symlink_to("letter")
    code, _, err = command("sweep", file, "--out", out, "--jobs", 1, "--resume")
    assert (code, err) == (0, "")
    assert {path.name for path in folder.iterdir()} == letters
    assert {path.read_text() for path in folder.iterdir()} == {"mine"}
