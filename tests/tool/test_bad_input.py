"""Bad input: one line that says where, what and what is allowed; exit code 2; nothing written."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from crosscheck.models.files import HERE
from crosscheck.planning.plan import OWN_NAMES
from tests.tool.conftest import Answer

ARM = (HERE / "arms" / "paper-labelled.toml").read_text(encoding="utf-8")
SCENARIO = (HERE / "scenarios" / "constant-torque.toml").read_text(encoding="utf-8")
DRIVE = 'kind = "constant"\ntorque_N_m = 100.0'


def assert_one_line(answer: Answer, *fragments: str) -> None:
    """Exit code 2 and a single line on stderr with every fragment."""
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("crosscheck: ")
    assert answer.err.count("\n") == 1
    assert answer.err.endswith("\n")
    for fragment in fragments:
        assert fragment in answer.err


BAD_ARMS = {
    "unknown key": (
        "backlash_m = 50e-6",
        "backlash = 50e-6",
        "joints[0].sun_mesh.backlash",
        "5e-05",
        "backlash_m",
    ),
    "unknown key at the top": ("payload_mass_kg", "payload", "payload", "10.0", "payload_mass_kg"),
    "missing key": ("sun_teeth = 27", "", "joints[0].sun_teeth", "missing"),
    "text for a number": (
        "sun_mass_kg = 0.39",
        'sun_mass_kg = "0.39"',
        "joints[0].sun_mass_kg",
        "'0.39'",
        "number",
    ),
    "fraction for a count": (
        "sun_teeth = 27",
        "sun_teeth = 27.5",
        "joints[0].sun_teeth",
        "27.5",
        "integer",
    ),
    "truth for a number": (
        "sun_mass_kg = 0.39",
        "sun_mass_kg = true",
        "joints[0].sun_mass_kg",
        "True",
        "number",
    ),
    "negative mass": (
        "sun_mass_kg = 0.39",
        "sun_mass_kg = -1.5",
        "joints[0].sun_mass_kg",
        "-1.5",
        "must be 0, or 1e-12 to 1e9 kg",
    ),
    "negative damping": (
        "damping_ratio = 0.05",
        "damping_ratio = -0.05",
        "joints[0].sun_mesh.damping_ratio",
        "-0.05",
        "must be 0, or 1e-9 to 10",
    ),
    "zero stiffness": (
        "mean_N_per_m = 1e8",
        "mean_N_per_m = 0.0",
        "joints[0].sun_mesh.stiffness.mean_N_per_m",
        "0.0",
        "must be 1 to 1e12 N/m",
    ),
    "not a number": ("backlash_m = 50e-6", "backlash_m = nan", "sun_mesh.backlash_m = nan"),
    "infinite": (
        "payload_mass_kg = 10.0",
        "payload_mass_kg = inf",
        "payload_mass_kg",
        "inf",
        "1e9 kg",
    ),
    "infinite phase": (
        "phase_rad = 0.0",
        "phase_rad = -inf",
        "joints[0].ring_mesh.phase_rad",
        "-inf",
        "-1000 to 1000 rad",
    ),
    "stiffness that turns negative": (
        "amplitude_N_per_m = 2e7",
        "amplitude_N_per_m = 2e8",
        "joints[0].sun_mesh.stiffness.amplitude_N_per_m",
        "200000000.0",
        "1e+08",
    ),
    "gears of unequal reach": (
        "ring_teeth = 99",
        "ring_teeth = 98",
        "joints[0].ring_teeth",
        "98",
        "99",
    ),
    "planets that do not mesh": (
        "planet_count = 3",
        "planet_count = 4",
        "joints[0].planet_count",
        "4",
        "126",
    ),
    "planets that collide": (
        "planet_count = 3",
        "planet_count = 6",
        "joints[0].planet_count",
        "6",
        "collide",
    ),
    "two ways to damp": (
        "damping_ratio = 0.05",
        "damping_ratio = 0.05\ndamping_N_s_per_m = 1.0",
        "damping_ratio",
        "damping itself",
    ),
    "no way to damp": (
        "damping_ratio = 0.05",
        "",
        "joints[0].sun_mesh.damping_ratio",
        "damping itself",
    ),
    "centre of mass off the link": ("com_m = 0.5", "com_m = 1.5", "links[0].com_m", "1.5", "1"),
    "a link too many": (
        "[[links]]",
        "[[links]]\nlength_m = 1.0\ncom_m = 0.5\ncross_section_m2 = 0.01\n"
        "density_kg_per_m3 = 1.0\n[[links]]",
        "links",
        "2",
    ),
    "another schema": ("schema_version = 2", "schema_version = 1", "schema_version", "1", "be 2"),
    "joint of no kind": ('kind = "planetary"\n', "", "joints[0]", "table with a kind"),
    "not TOML": ("payload_mass_kg = 10.0", "payload_mass_kg 10.0", "not TOML"),
    "same key twice": ("sun_teeth = 27", "sun_teeth = 27\nsun_teeth = 27", "not TOML"),
    "list for a number": (
        "payload_mass_kg = 10.0",
        "payload_mass_kg = [10.0]",
        "payload_mass_kg",
        "[10.0]",
        "number",
    ),
    "joints as one table": ("[[joints]] # shoulder", "[joints] # shoulder", "not TOML"),
    "no name": ('name = "paper-labelled"', 'name = ""', "name", "''", "1 to 80 printable"),
}


@pytest.mark.parametrize("case", BAD_ARMS)
def test_bad_arm_is_named_with_field_and_value(short, tmp_path, case):
    old, new, *fragments = BAD_ARMS[case]
    text = ARM.replace(old, new, 1)
    assert text != ARM
    file = tmp_path / "arm.toml"
    file.write_text(text)
    assert_one_line(short(arm=file), str(file), *fragments)
    assert list(tmp_path.iterdir()) == [file]


TABLE = 'kind = "table"\ntime_s = [0.0, 0.1, 1.0]\ntorque_N_m = [[0.0, 1.0, 2.0], [0.0, 1.0, 2.0]]'
PD = 'kind = "pd"\ntarget_rad = 0.5\nproportional_N_m_per_rad = 1.0\nderivative_N_m_s_per_rad = 1.0'
BAD_SCENARIOS = {
    "unknown drive": ('kind = "constant"', 'kind = "bang"', "drive", "bang", "constant"),
    "unknown key of the drive": (
        "torque_N_m = 100.0",
        "torque = 100.0",
        "drive.torque",
        "100.0",
        "torque_N_m",
    ),
    "no drive": ("[drive]\n" + DRIVE, "", "drive", "missing"),
    "no torque": ("torque_N_m = 100.0", "", "drive.torque_N_m", "missing"),
    "torque not a number": ("torque_N_m = 100.0", "torque_N_m = nan", "drive.torque_N_m", "nan"),
    "torque as text": ("torque_N_m = 100.0", 'torque_N_m = "much"', "drive.torque_N_m", "'much'"),
    "torques of three joints": (
        "torque_N_m = 100.0",
        "torque_N_m = [1.0, 2.0, 3.0]",
        "drive.torque_N_m",
        "2",
        "3",
    ),
    "targets of three joints": (
        DRIVE,
        PD.replace("0.5", "[0.1, 0.2, 0.3]"),
        "drive.target_rad",
        "2",
        "3",
    ),
    "start of three joints": (
        'mesh = "contact"',
        "theta_rad = [0.1, 0.2, 0.3]",
        "start.theta_rad",
        "2",
        "3",
    ),
    "unknown start": (
        'mesh = "contact"',
        'mesh = "somewhere"',
        "start.mesh",
        "'somewhere'",
        "'centre'",
    ),
    "table too short": (DRIVE, TABLE.replace("1.0]\n", "0.2]\n"), "drive.time_s", "0.5"),
    "table that begins late": (
        DRIVE,
        TABLE.replace("[0.0, 0.1, 1.0]", "[0.05, 0.1, 1.0]"),
        "drive.time_s",
        "0.5",
    ),
    "table that goes back": (
        DRIVE,
        TABLE.replace("[0.0, 0.1, 1.0]", "[0.0, 1.0, 0.1]"),
        "time_s",
        "increase",
    ),
    "table with a short column": (
        DRIVE,
        TABLE.replace("[[0.0, 1.0, 2.0]", "[[0.0, 1.0]"),
        "torque_N_m",
        "3",
    ),
    "table of one joint": (
        DRIVE,
        TABLE.replace(", [0.0, 1.0, 2.0]]", "]"),
        "drive.torque_N_m",
        "2",
        "1",
    ),
    "negative duration": (
        "duration_s = 0.5",
        "duration_s = -0.5",
        "duration_s",
        "-0.5",
        "must be 1e-9 to 1e6 s",
    ),
    "step that does not divide": ("step_s = 1e-5", "step_s = 3e-5", "step_s", "3e-05", "0.5"),
    "huge number of steps": ("step_s = 1e-5", "step_s = 1e-12", "step_s", "1e-12", "1e9"),
    "step too large for the run": ("step_s = 1e-5", "step_s = 1.0", "step_s", "1.0", "0.5"),
    "record never": ("record_every = 10", "record_every = 0", "record_every", "0", "1"),
}


@pytest.mark.parametrize("case", BAD_SCENARIOS)
def test_bad_scenario_is_named_with_field_and_value(short, tmp_path, case):
    old, new, *fragments = BAD_SCENARIOS[case]
    text = SCENARIO.replace(old, new, 1)
    assert text != SCENARIO
    file = tmp_path / "scenario.toml"
    file.write_text(text)
    assert_one_line(short("--scenario", file), *fragments)
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("case", BAD_SCENARIOS)
def test_bad_scenario_is_named_with_its_file(short, tmp_path, case):
    old, new, *_ = BAD_SCENARIOS[case]
    file = tmp_path / "scenario.toml"
    file.write_text(SCENARIO.replace(old, new, 1))
    assert_one_line(short("--scenario", file), str(file))


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


def no_file(path: Path) -> None:
    """Leave it missing."""


def big_file(path: Path) -> None:
    """100 MB of zeros that take no room."""
    path.touch()
    os.truncate(path, 100_000_000)


FILES = {
    "missing": (no_file, "no such file"),
    "empty": (lambda path: path.write_text(""), "empty"),
    "blank": (lambda path: path.write_text(" \n\n"), "empty"),
    "folder": (lambda path: path.mkdir(), "cannot be read"),
    "binary": (lambda path: path.write_bytes(bytes(range(256))), "not UTF-8"),
    "zeros": (lambda path: path.write_bytes(bytes(64)), "not TOML"),
    "not TOML": (lambda path: path.write_text("{json: true}"), "not TOML"),
    "link in a circle": (lambda path: path.symlink_to(path), "cannot be read"),
    "broken link": (lambda path: path.symlink_to("nowhere"), "no such file"),
    "pipe": (os.mkfifo, "not a regular file"),
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


OPTIONS = {
    "unknown model": (("--model", "adams:arm"), "model", "adams:arm", "exudyn:tree"),
    "model that cannot simulate": (
        ("--model", "pinocchio:gears"),
        "pinocchio:gears",
        "cannot simulate",
    ),
    "unknown scenario": (("--scenario", "waltz"), "waltz", "constant-torque"),
    "unknown phase": (("--phase", "beta"), "phase", "beta", "omega_t"),
    "unknown ring rate": (("--ring-rate", "27"), "ring-rate", "27", "eq13"),
    "negative duration": (("--t-end", "-0.1"), "duration_s", "-0.1", "1e-9 to 1e6 s"),
    "no duration": (("--t-end", "0"), "duration_s", "0", "1e-9 to 1e6 s"),
    "duration not a number": (("--t-end", "nan"), "duration_s", "nan"),
    "infinite duration": (("--t-end", "inf"), "duration_s", "inf"),
    "duration in words": (("--t-end", "long"), "duration_s", "long", "valid number"),
    "duration that is no multiple": (("--t-end", "0.0100049"), "step_s", "0.0100049"),
    "duration below a step": (("--t-end", "1e-6"), "step_s", "1e-05", "1e-06"),
    "huge duration": (("--t-end", "1e7"), "duration_s", "1e6"),
    "long duration": (("--t-end", "1e5"), "step_s", "1e9"),
    "negative step": (("--step", "-1e-5"), "step_s", "-1e-05", "1e-12 to 1 s"),
    "no step": (("--step", "0"), "step_s", "0", "1e-12 to 1 s"),
    "tiny step": (("--step", "1e-300"), "step_s", "1e-300", "1e-12"),
    "small step": (("--step", "1e-12"), "step_s", "1e-12", "1e9"),
    "setting without a value": (("--set", "arm.name"), "--set", "arm.name", "path=value"),
    "setting of nothing": (("--set", "=1"), "--set", "path=value"),
    "setting of a section": (("--set", "arm=1"), "--set", "arm=1", "path=value"),
    "setting elsewhere": (("--set", "robot.name=x"), "--set", "robot", "arm, scenario, switches"),
    "setting of an unknown list": (
        ("--set", "arm.axes.0.x=1"),
        "--set",
        "arm.axes",
        "no such entry",
    ),
    "setting of an unknown key": (("--set", "arm.joints.0.slack=1"), "joints[0].slack", "1"),
    "setting past the end": (("--set", "arm.joints.2.sun_teeth=27"), "arm.joints.2", "0 to 1"),
    "setting of a negative index": (
        ("--set", "arm.joints.-1.*_mesh.backlash_m=0.0"),
        "arm.joints.-1",
        "0 to 1",
    ),
    "setting below a number": (
        ("--set", "arm.payload_mass_kg.x=1"),
        "arm.payload_mass_kg",
        "no such entry",
    ),
    "setting of a wrong type": (
        ("--set", "arm.joints.*.*_mesh.backlash_m=wide"),
        "joints[0].sun_mesh.backlash_m",
        "'wide'",
        "number",
    ),
    "setting out of range": (
        ("--set", "arm.joints.1.*_mesh.backlash_m=-1e-6"),
        "joints[1].sun_mesh.backlash_m",
        "-1e-06",
    ),
    "setting of an unknown switch": (("--set", "switches.friction=on"), "friction", "on"),
    "setting of an unknown law": (
        ("--set", "switches.damping=never"),
        "damping",
        "'never'",
        "contact",
    ),
    "step beyond stability": (
        ("--step", "1e-4"),
        "step_s",
        "0.0001",
        "largest stable step",
        "--force",
    ),
    "unknown option": (("--fast",), "--fast", "--help"),
}


@pytest.mark.parametrize("case", OPTIONS)
def test_bad_option_is_named_with_its_value(short, tmp_path, case):
    arguments, *fragments = OPTIONS[case]
    assert_one_line(short(*arguments), *fragments)
    assert list(tmp_path.iterdir()) == []


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
