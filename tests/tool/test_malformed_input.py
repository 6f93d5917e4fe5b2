"""Input that is broken in its structure, however cleverly: one printable line, quickly."""

from typing import Any

import pytest

from crosscheck.cli.app import build_commands
from crosscheck.models.errors import LONGEST_LINE, Diverged, InputError, format_line
from crosscheck.models.files import HERE, is_robot
from crosscheck.models.loading import load_arm, load_case
from tests.loops import require_items
from tests.tool.test_bad_input import assert_one_line

ARM = (HERE / "arms" / "paper-labelled.toml").read_text(encoding="utf-8")
SUN = "sun_teeth = 27"
DIGITS = "9" * 5000


def first(old: str, new: str) -> str:
    """The arm's text with the first such place changed."""
    assert old in ARM
    return ARM.replace(old, new, 1)


MALFORMED = {
    "key that a drive is called": (f"table = 1\n{ARM}", "table = 1: unknown key"),
    "key that begins like a function": (f'funding = "x"\n{ARM}', "funding = 'x': unknown key"),
    "key that a list is called": (f"list = []\n{ARM}", "list = []: unknown key"),
    "unknown key in a joint": (first(SUN, f"{SUN}\nfunny = 1"), "joints[0].funny = 1: unknown key"),
    "key of a thousand characters": (first(SUN, f"{SUN}\n{'k' * 1000} = 1"), "unknown key"),
    "key with a line break": (first(SUN, f'{SUN}\n"a\\nb" = 1'), "joints[0].a\\nb = 1"),
    "integer of 5000 digits": (first(SUN, f"sun_teeth = {DIGITS}"), "too many digits"),
    "integer of 6000 hexadecimals": (first(SUN, f"sun_teeth = 0x{'f' * 6000}"), "too many digits"),
    "number of 5000 digits": (
        first("sun_mass_kg = 0.39", f"sun_mass_kg = {DIGITS}.0"),
        "joints[0].sun_mass_kg = inf: must be 0, or 1e-12 to 1e9 kg",
    ),
    "brackets without end": (f"a = {'[' * 5000}\n{ARM}", "nested too deeply"),
    "tables without end": (f"a = {'{a = ' * 5000}\n{ARM}", "nested too deeply"),
    "key of 100,000 parts": (f"{'a.' * 100_000}a = 1\n{ARM}", "a key of more than 50 parts"),
    "zero byte": (f"{ARM}\x00", "not TOML"),
    "date": (first("sun_mass_kg = 0.39", "sun_mass_kg = 1979-05-27"), "datetime.date(1979, 5, 27)"),
    "table for a number": (first(SUN, "sun_teeth.x = 1"), "joints[0].sun_teeth = {'x': 1}"),
    "name as a table": (f"name.x = 1\n{ARM}", "not TOML"),
    "another list of tables": (first("[[links]]", "[[joints]]"), "joints[2]"),
    "numbers for joints": (
        "joints = [1, 2]\n" + ARM.split("[[joints]]")[0],
        "joints[0] = 1: must be a table",
    ),
    "number for joints": ("joints = 1\n" + ARM.split("[[joints]]")[0], ": must be a list"),
    "schema version true": (first("schema_version = 2", "schema_version = true"), "schema_version"),
    "schema version 2.0": (first("schema_version = 2", "schema_version = 2.0"), "schema_version"),
    "title of 5000 characters": (first("title = ", f"title = '{'t' * 5000}' #"), "title"),
}  # fmt: skip


@pytest.mark.parametrize("case", MALFORMED)
def test_malformed_arm_is_refused_in_one_short_line(crosscheck, tmp_path, case):
    text, fragment = MALFORMED[case]
    file = tmp_path / "arm.toml"
    file.write_text(text, encoding="utf-8")
    assert_one_line(crosscheck("show", file), str(file), fragment)


XML_FILES = {
    "URDF": ('<?xml version="1.0"?>\n<robot name="r"/>', "is a URDF", "other commands take it"),
    "URDF that xacro has written": (
        '\ufeff<!-- <xacro:a b="${c}"/> --><robot xmlns:xacro="x"/>',
        "is a URDF",
        "other commands take it",
    ),
    "xacro": ('<!DOCTYPE r><robot><a b="${c}"/></robot>', "is xacro", "expand it first"),
    "MJCF": ("\n<mujoco/>", "is MJCF", "other commands take it"),
    "SDF": ("<sdf version='1.7'>", "is SDF", "other commands take a URDF"),
    "another": ("<!-- without end", "is XML", "other commands take a URDF"),
}


@pytest.mark.parametrize("kind", XML_FILES)
def test_xml_in_place_of_an_arm_is_called_what_it_is(tmp_path, kind):
    text, *fragments = XML_FILES[kind]
    file = tmp_path / "arm.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as error:
        load_arm(str(file))
    for fragment in (f"{file}: is", "an arm's TOML file", *fragments):
        assert fragment in str(error.value)
    assert is_robot(str(file))


SETTINGS = {
    "arm.pd=1": "pd = 1: unknown key",
    "scenario.table=1": "table = 1: unknown key",
    "scenario.drive.constant=1": "drive.constant = 1: unknown key",
    "=": "path=value",
    ".=1": "path=value",
    "arm.=1": "path=value",
    "arm..name=x": "path=value",
    "arm.joints.-1=1": "arm.joints.-1: index must be * or 0 to 1",
    "arm.joints.*.*_wheel=1": "arm.joints.*.*_wheel: no such entry",
    "arm.joints.*.*.*=1": "arm.joints.*.*.*: no such entry",
    "arm.joints.\u0661.*_mesh.backlash_m=0.0": "index must be",
    f"arm.joints.{DIGITS}.*_mesh.backlash_m=0.0": "index must be",
    "arm.joints.00000000000000000.*_mesh.backlash_m=0.0": "index must be",
    f"arm.joints.0.sun_teeth={DIGITS}": "joints[0].sun_teeth",
    f"arm.payload_mass_kg={'[' * 3000}": "payload_mass_kg = '[[[",
    f"arm.{'a.' * 3000}b=1": "no such entry",
    "arm.payload_mass_kg=1.0\nx = 2": "payload_mass_kg = '1.0\\nx = 2'",
    "arm.name=": "name = ''",
    "scenario.drive={}": "drive = {}: must be a table with a kind",
    "scenario.drive=5": "drive = 5: must be a table",
    "arm.joints.1.kind=planetry": "joints[1].kind = 'planetry': must be one of 'planetary'",
    "switches.phase=[1]": "phase = [1]",
    f"arm.{'k' * 1000}=1": "unknown key",
    "arm.a\x1b[31m=1": "a\\x1b[31m = 1: unknown key",
}


@pytest.mark.parametrize("setting", SETTINGS, ids=range(len(SETTINGS)))
def test_malformed_setting_is_refused_in_one_short_line(short, setting):
    assert_one_line(short("--set", setting), SETTINGS[setting])


@pytest.mark.parametrize("name", ["/dev/null", "/dev/zero", "x" * 300, "a/b\nc", ""])
def test_name_that_is_no_file_is_refused(crosscheck, name):
    assert_one_line(crosscheck("show", name), "cannot be read" if "\n" not in name else "a/b\\nc")


def test_settings_share_nothing():
    """A table given to every joint is each joint's own."""
    drive = "scenario.drive={kind='table', time_s=[0, 9], torque_N_m=[[0, 1], [0, 1]]}"
    settings = [drive, "scenario.drive.torque_N_m.*=[5, 6]", "scenario.drive.torque_N_m.1.0=7"]
    case = load_case("probe", "constant-torque", {}, settings)
    assert case.scenario.model_dump()["drive"]["torque_N_m"] == ((5.0, 6.0), (7.0, 6.0))


def test_error_line_keeps_a_piece_of_every_part():
    error = InputError("w" * 999, "f" * 999, "v" * 999, "a" * 999)
    assert len(f"crosscheck: {error}") <= LONGEST_LINE
    for part in ("w" * 40, ": " + "f" * 40, " = 'vv", ": " + "a" * 40, "..."):
        assert part in str(error)


def test_any_text_becomes_one_line():
    assert format_line("choose:\n\ta,\n\tb\r\n") == "choose: a, b"
    assert format_line("a\x1b[2J\u202eb\ud800\x00") == r"a\x1b[2J\u202eb\ud800\x00"
    assert len(format_line("word " * 1000)) <= LONGEST_LINE
    assert format_line(str(Diverged("a:b", 0.25))) == "a:b: diverged at t = 0.25 s"


def help_texts(command: Any, path: str = "") -> dict[str, list[str]]:
    """Every command below, and the help texts of its options."""
    found = {path: [text for p in command.params if (text := getattr(p, "help", None))]}
    for name, inner in getattr(command, "commands", {}).items():
        found |= help_texts(inner, f"{path} {name}")
    return found


HELP = help_texts(build_commands())


@pytest.mark.parametrize("command", [command for command, texts in HELP.items() if texts])
def test_help_shows_every_text_whole(crosscheck, monkeypatch, command):
    monkeypatch.setenv("COLUMNS", "300")
    shown = " ".join(crosscheck(*command.split(), "--help").out.split())
    for text in require_items(HELP[command]):
        assert text in shown


def test_refused_arm_shows_nothing_of_itself(crosscheck, monkeypatch):
    def broken(*_: object) -> None:
        raise OverflowError("too large")

    monkeypatch.setattr("crosscheck.cli.show.PhysicalModel", broken)
    assert_one_line(crosscheck("show", "probe"), "probe: show cannot use its numbers", "too large")
