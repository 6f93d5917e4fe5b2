"""Bad input: one line that says where, what and what is allowed; exit code 2; nothing written."""

import os
import tomllib
from pathlib import Path

import pytest

from crosscheck.models.files import HERE
from crosscheck.planning.plan import OWN_NAMES
from tests.obstacles import OBSTACLES
from tests.processes import Answer

BAD = tomllib.loads(Path(__file__).with_name("bad_input.toml").read_text(encoding="utf-8"))
SCENARIO = (HERE / "scenarios" / "constant-torque.toml").read_text(encoding="utf-8")


def assert_one_line(answer: Answer, *fragments: str) -> None:
    """Exit code 2 and a single line on stderr with every fragment."""
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("crosscheck: ")
    assert answer.err.count("\n") == 1
    assert answer.err.endswith("\n")
    for fragment in fragments:
        assert fragment in answer.err


@pytest.mark.parametrize(
    ("arm", "case"), [(arm, case) for arm, cases in BAD["arms"].items() for case in cases]
)
def test_bad_arm_is_named_with_field_and_value(short, tmp_path, arm, case):
    old, new, *fragments = BAD["arms"][arm][case]
    file = changed(tmp_path / "arm.toml", (HERE / "arms" / f"{arm}.toml").read_text(), old, new)
    assert_one_line(short(arm=file), str(file), *fragments)
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("case", BAD["scenarios"])
def test_bad_scenario_is_named_with_file_field_and_value(short, tmp_path, case):
    old, new, *fragments = BAD["scenarios"][case]
    file = changed(tmp_path / "scenario.toml", SCENARIO, old, new)
    assert_one_line(short("--scenario", file), str(file), *fragments)
    assert list(tmp_path.iterdir()) == [file]


def changed(file: Path, text: str, old: str, new: str) -> Path:
    """The file, written with the first ``old`` of a text changed."""
    assert old in text
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    return file


@pytest.mark.parametrize(
    ("arm", "case"), [(arm, case) for arm, cases in BAD["options"].items() for case in cases]
)
def test_bad_option_is_named_with_its_value(short, tmp_path, arm, case):
    arguments, *fragments = BAD["options"][arm][case]
    assert_one_line(short(*arguments, arm=arm), *fragments)
    assert list(tmp_path.iterdir()) == []


THREE_TORQUES = SCENARIO.replace("torque_N_m = 100.0", "torque_N_m = [1.0, 2.0, 3.0]")
COMMANDS = {
    "run": ("run", "paper-labelled"),
    "validate": ("validate", "paper-labelled"),
    "baseline": ("baseline", "check", "paper-labelled"),
}


@pytest.mark.parametrize("command", COMMANDS)
def test_scenario_of_another_number_of_joints_is_refused(crosscheck, tmp_path, command):
    file = tmp_path / "scenario.toml"
    file.write_text(THREE_TORQUES)
    answer = crosscheck(*COMMANDS[command], "--scenario", file)
    assert_one_line(answer, str(file), "drive.torque_N_m", "needs 2 values, has 3")
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("command", COMMANDS)
def test_setting_of_a_scenario_needs_one(crosscheck, tmp_path, command, monkeypatch):
    monkeypatch.chdir(tmp_path)
    answer = crosscheck(*COMMANDS[command], "--set", "scenario.duration_s=0.1")
    assert_one_line(answer, "--set", "scenario.duration_s=0.1", "needs --scenario")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", COMMANDS)
def test_two_scenarios_of_one_name_are_refused(crosscheck, tmp_path, command, monkeypatch):
    monkeypatch.chdir(tmp_path)
    answer = crosscheck(*COMMANDS[command], "--scenario", "pd", "--scenario", "pd")
    assert_one_line(answer, "name", "pd", "no other experiment")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", OWN_NAMES)
def test_names_of_the_plan_are_not_for_scenarios(crosscheck, tmp_path, name):
    file = tmp_path / "scenario.toml"
    file.write_text(SCENARIO.replace('name = "constant-torque"', f'name = "{name}"'))
    answer = crosscheck("run", "paper-labelled", "--scenario", file, "--out", tmp_path / "report")
    assert_one_line(answer, "name", name, "no other experiment")
    assert list(tmp_path.iterdir()) == [file]


def big_file(path: Path) -> None:
    """100 MB of zeros that take no room."""
    path.touch()
    os.truncate(path, 100_000_000)


FILES = {
    "missing": (lambda path: None, "no such file"),
    "empty": (lambda path: path.write_text(""), "empty"),
    "blank": (lambda path: path.write_text(" \n\n"), "empty"),
    "folder": (OBSTACLES["folder"], "cannot be read"),
    "binary": (lambda path: path.write_bytes(bytes(range(256))), "not UTF-8"),
    "zeros": (lambda path: path.write_bytes(bytes(64)), "not TOML"),
    "not TOML": (lambda path: path.write_text("{json: true}"), "not TOML"),
    "link in a circle": (OBSTACLES["loop"], "cannot be read"),
    "broken link": (OBSTACLES["dangling"], "no such file"),
    "pipe": (OBSTACLES["pipe"], "not a regular file"),
    "100 MB": (big_file, "more than 4 MB"),
}


@pytest.mark.parametrize("command", ["simulate", "show", "run", "scenario"])
@pytest.mark.parametrize("kind", FILES)
def test_unreadable_file_is_named(crosscheck, short, tmp_path, kind, command):
    make, reason = FILES[kind]
    file = tmp_path / "input.toml"
    make(file)
    commands = {
        "simulate": lambda: short(arm=file),
        "scenario": lambda: short("--scenario", file),
        "show": lambda: crosscheck("show", file),
        "run": lambda: crosscheck("run", file, "--out", tmp_path / "report"),
    }
    assert_one_line(commands[command](), str(file), reason)
    assert [path.name for path in tmp_path.iterdir()] in ([], ["input.toml"])


@pytest.mark.parametrize("model", ["analytic:physical", "exudyn:tree"])
def test_largest_stable_step_that_is_named_is_accepted(short, tmp_path, model):
    refused = short("--step", "1e-4", model=model)
    limit = float(refused.err.split(f"largest stable step of {model} is ")[1].split(" s")[0])
    assert 2e-5 < limit < 1e-4
    # The message rounds to three digits; the next multiple below 1 % less divides 10 steps.
    step = 0.99 * limit
    answer = short("--step", step, "--t-end", 10 * step, model=model)
    assert answer.code == 0
    assert (tmp_path / "run.nc").is_file()


@pytest.mark.parametrize("model", ["analytic:physical", "exudyn:tree"])
def test_forced_run_that_diverges_says_when_and_writes_nothing(short, tmp_path, model):
    answer = short("--step", "5e-4", "--t-end", "0.5", "--force", model=model)
    assert_one_line(answer, model, "diverged at t = ")
    assert list(tmp_path.iterdir()) == []


def test_forced_run_within_stability_goes_on(short):
    assert short("--force").code == 0


@pytest.mark.parametrize("command", ["simulate", "run"])
def test_folder_below_a_file_cannot_be_written(crosscheck, tmp_path, command):
    file = tmp_path / "file"
    file.write_text("mine")
    arguments = ("--model", "analytic:links", "--scenario", "pd") if command == "simulate" else ()
    out = file / "below" / "run.nc"
    answer = crosscheck(command, "paper-labelled", *arguments, "--out", out)
    assert_one_line(answer, str(file / "below"), "cannot be written")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
    assert file.read_text() == "mine"


def test_folder_is_no_file_to_write(crosscheck, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path.parent)
    arguments = ("--model", "analytic:links", "--scenario", "pd", "--out", tmp_path.name)
    answer = crosscheck("simulate", "paper-labelled", *arguments)
    assert_one_line(answer, "--out", tmp_path.name, "folder")
    assert list(tmp_path.iterdir()) == []


def test_bad_input_makes_no_folder(crosscheck, tmp_path):
    out = tmp_path / "new" / "run.nc"
    arguments = ("--model", "adams:arm", "--scenario", "pd", "--out", out)
    assert crosscheck("simulate", "paper-labelled", *arguments).code == 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "arguments",
    [
        ("fly",),
        ("run", "--jobs", "0"),
        ("run", "--seed", "-1"),
        ("simulate",),
        ("show",),
        ("run", "a", "b"),
    ],
)
def test_wrong_usage_is_one_line(crosscheck, arguments):
    assert_one_line(crosscheck(*arguments), "--help")


def test_a_cross_check_refuses_lumped_planets_that_differ(crosscheck, tmp_path):
    more = ("--quick", "--set", "switches.planets=lumped", "--json", tmp_path / "a.json")
    answer = crosscheck("validate", "planets-apart", *more)
    assert_one_line(answer, "planets-apart", "joints[0].sun_mesh.", "planets = free")
    assert list(tmp_path.iterdir()) == []


def test_the_papers_own_arm_may_have_free_planets(short):
    assert short("--set", "switches.planets=free").code == 0
    assert short("--set", "arm.joints.*.*_mesh.backlash_m=[5e-5, 4e-5, 5e-5]").code == 0
