"""Bad input: one line that says where, what and what is allowed; exit code 2; nothing written."""

import os
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.models import inputs
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import LONGEST_LINE, Diverged, InputError, format_line
from crosscheck.models.files import HERE, is_robot
from crosscheck.models.loading import Case, load_arm, load_case, load_scenario
from crosscheck.models.robot.file import load_robot
from crosscheck.planning.plan import RESERVED_NAMES, Experiment, make_energy_experiments
from tests.obstacles import OBSTACLES
from tests.processes import Answer
from tests.tool.supplied import TWO_LINK

BAD = tomllib.loads(Path(__file__).with_name("bad_input.toml").read_text(encoding="utf-8"))
ARM, SCENARIO = (
    (HERE / file).read_text(encoding="utf-8")
    for file in ("arms/paper-labelled.toml", "scenarios/constant-torque.toml")
)
USUAL = "--model analytic:physical --scenario constant-torque --t-end 0.002 --out run.nc"
TRIAL = "--quick --jobs 1 --json t.json --junit t.xml"
FILES = {
    "file": "mine",
    "three.toml": SCENARIO.replace("torque_N_m = 100.0", "torque_N_m = [1.0, 2.0, 3.0]"),
    "mine.py": f"{TWO_LINK}\n\nconstant = Equations(mass_matrix=lambda q: np.eye(2))\n\n"
    "def without(arm): return replace(two_link(arm), force=None)\n",
} | {
    f"{name}.toml": SCENARIO.replace('name = "constant-torque"', f'name = "{name}"')
    for name in RESERVED_NAMES
}


def assert_one_line(answer: Answer, *fragments: str) -> None:
    """Exit code 2 and a single line on stderr, printable and short, with every fragment."""
    assert (answer.code, answer.out) == (2, "")
    line, end = answer.err[:-1], answer.err[-1:]
    assert (line.isprintable(), end) == (True, "\n"), answer.err
    assert line.startswith("crosscheck: ")
    assert len(line) <= LONGEST_LINE
    for fragment in fragments:
        assert fragment in answer.err


def expand(text: str) -> str:
    """A text with ``{N x text}`` written out."""
    return re.sub(r"\{(\d+) x (.+?)\}", lambda found: int(found[1]) * found[2], text)


def change(text: str, old: str, new: str) -> str:
    """The text with the first such place changed."""
    assert old in text
    return text.replace(old, expand(new), 1)


def list_refused() -> Iterator[tuple[str, str, dict[str, str]]]:
    """Name, command line and files of every row of the table."""
    for arm, cases in BAD["arms"].items():
        text = (HERE / "arms" / f"{arm}.toml").read_text(encoding="utf-8")
        for name, row in cases.items():
            yield f"{arm}, {name}", f"simulate a.toml {USUAL}", {"a.toml": change(text, *row)}
    for name, row in BAD["scenarios"].items():
        line = "simulate paper-labelled --model analytic:physical --scenario s.toml --out run.nc"
        yield f"scenario, {name}", line, {"s.toml": change(SCENARIO, *row)}
    for name, row in BAD["malformed"].items():
        yield f"malformed, {name}", "show a.toml", {"a.toml": change(ARM, *row)}
    reserved = [f"run paper-labelled --scenario {name}.toml" for name in RESERVED_NAMES]
    for line in (*BAD["commands"]["given"], *reserved):
        yield line, line, FILES
    equations = {f"equations, {name}": row for name, row in BAD["equations"].items()}
    for section, changed in (("coordinates", "coordinates=Coordinates({})"), ("answers", "{}")):
        for name, given in BAD[section].items():
            more = f"def f(arm): return replace(two_link(arm), {changed.format(given)})"
            equations[f"{section}, {name}"] = (more, "f")
    for name, (more, tried) in equations.items():
        yield name, f"trial mine.py:{tried} {TRIAL}", {"mine.py": f"{TWO_LINK}\n\n{more}\n"}


def list_options() -> Iterator[tuple[str, list[str]]]:
    """Name and words of every option or setting of a run."""
    for arm, cases in BAD["options"].items():
        for name, words in cases.items():
            yield f"{arm}, option, {name}", ["simulate", arm, *USUAL.split(), *words]
    for given in BAD["settings"]["given"]:
        words = ["simulate", "paper-labelled", *USUAL.split(), "--set", expand(given)]
        yield f"setting {given}", words


REFUSED: dict[str, tuple[list[str], dict[str, str]]] = {
    **{name: (expand(line).split(), files) for name, line, files in list_refused()},
    **{name: (words, {}) for name, words in list_options()},
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input_is_refused_in_one_line_and_nothing_is_written(
    refuse, tmp_path, case, snapshot: SnapshotAssertion
):
    (tmp_path / "there").mkdir()
    line = refuse(*REFUSED[case])
    assert re.sub(r"\(see .*?crosscheck", "(see crosscheck", line) == snapshot


@pytest.mark.parametrize("kind", BAD["texts"])
def test_xml_in_place_of_an_arm_is_called_what_it_is(
    tmp_path, monkeypatch, kind, snapshot: SnapshotAssertion
):
    monkeypatch.chdir(tmp_path)
    Path("arm.toml").write_text(BAD["texts"][kind], encoding="utf-8")
    with pytest.raises(InputError) as error:
        load_arm("arm.toml")
    assert str(error.value) == snapshot
    assert is_robot("arm.toml")


@pytest.mark.parametrize("name", ["a/b\nc", ""])
def test_name_that_is_no_file_is_refused(crosscheck, name):
    assert_one_line(crosscheck("show", name), "a/b\\nc" if name else "cannot be read")


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


def test_refused_arm_shows_nothing_of_itself(crosscheck, monkeypatch):
    def broken(*_: object) -> None:
        raise OverflowError("too large")

    monkeypatch.setattr("crosscheck.cli.show.PhysicalModel", broken)
    assert_one_line(crosscheck("show", "probe"), "probe: show cannot use its numbers", "too large")


def test_a_scenario_cannot_take_the_name_of_an_experiment_on_energy(labelled):
    first = Experiment("pd", Case(labelled, load_scenario("pd"), usual_switches(labelled)))
    planned = {each.name for each in make_energy_experiments(labelled, first, 1e-5)}
    assert len(planned) == 4
    assert planned <= set(RESERVED_NAMES)


def big_file(path: Path) -> None:
    """100 MB of zeros that take no room."""
    path.touch()
    os.truncate(path, 100_000_000)


UNREADABLE = {
    "missing": (lambda path: None, "no such file"),
    "empty": (lambda path: path.write_text(""), "empty"),
    "blank": (lambda path: path.write_text(" \n\n"), "empty"),
    "folder": (OBSTACLES["folder"], "cannot be read: it is a folder"),
    "binary": (lambda path: path.write_bytes(bytes(range(256))), "not UTF-8"),
    "zeros": (lambda path: path.write_bytes(bytes(64)), "not TOML"),
    "not TOML": (lambda path: path.write_text("{json: true}"), "not TOML"),
    "link in a circle": (OBSTACLES["loop"], "cannot be read"),
    "broken link": (OBSTACLES["dangling"], "no such file"),
    "pipe": (OBSTACLES["pipe"], "not a regular file"),
    "100 MB": (big_file, "more than 4 MB"),
}


@pytest.mark.parametrize("command", ["simulate", "show", "run", "scenario"])
@pytest.mark.parametrize("kind", UNREADABLE)
def test_unreadable_file_is_named(crosscheck, short, tmp_path, kind, command):
    make, reason = UNREADABLE[kind]
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


def test_radians_of_many_turns_in_an_experiment_or_a_urdf_are_asked_about(tmp_path, caplog):
    inputs.forget()
    settings = [f"scenario.start.theta_rad={angles}" for angles in ("[0.0, 45.0]", "6.28318531")]
    for setting in (*settings, settings[0]):  # once of a field, and not of one turn
        others = "scenario.drive.target_rad=-90.0", "scenario.step_s=3.33333333e-5"  # 1 s / 30,000
        load_case("paper-labelled", "pd", settings=(setting, *others))
    origin = '<inertial><origin rpy="0 0 90" xyz="0.25 0 0"/>'
    text = (Path(__file__).parents[2] / "examples/gallery/pendulum.urdf").read_text(
        encoding="utf-8"
    )
    (tmp_path / "p.urdf").write_text(re.sub('<inertial><origin xyz="0.25 0 0"/>', origin, text))
    load_robot(tmp_path / "p.urdf")
    end = "turns: is it in degrees?"
    assert caplog.messages == [
        f"note: pd: start.theta_rad: 45 rad = 7.16 {end}",
        f"note: pd: drive.target_rad: -90 rad = 14.3 {end}",
        f"note: {tmp_path}/p.urdf: link upper: origin.rpy: 90 rad = 14.3 {end}",
    ]
