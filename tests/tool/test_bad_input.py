"""Bad input: one line that says where, what and what is allowed; exit code 2; nothing written."""

import os
import tomllib
from pathlib import Path

import pytest

from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import LONGEST_LINE
from crosscheck.models.files import HERE
from crosscheck.models.loading import Case, load_scenario
from crosscheck.planning.plan import RESERVED_NAMES, Experiment, make_energy_experiments
from tests.obstacles import OBSTACLES
from tests.processes import Answer

BAD = tomllib.loads(Path(__file__).with_name("bad_input.toml").read_text(encoding="utf-8"))
SCENARIO = (HERE / "scenarios" / "constant-torque.toml").read_text(encoding="utf-8")


def assert_one_line(answer: Answer, *fragments: str) -> None:
    """Exit code 2 and a single line on stderr, printable and short, with every fragment."""
    assert (answer.code, answer.out) == (2, "")
    line, end = answer.err[:-1], answer.err[-1:]
    assert (line.isprintable(), end) == (True, "\n"), answer.err
    assert line.startswith("crosscheck: ")
    assert len(line) <= LONGEST_LINE
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
RUN, PAPER = ("run", "paper-labelled"), ("simulate", "paper-labelled", "--scenario", "pd")
COMMANDS = (RUN, ("validate", "paper-labelled"), ("baseline", "check", "paper-labelled"))
LINKS = (*PAPER, "--model", "analytic:links", "--out")
LUMPED = ("validate", "planets-apart", "--quick", "--set", "switches.planets=lumped")
SET = ("--set", "scenario.duration_s=0.1")
# Arguments, and fragments of the line that refuses them.
REFUSED: list[tuple[tuple[str, ...], tuple[str, ...]]] = [
    *(
        ((*command, *more), said)
        for command in COMMANDS
        for more, said in (
            (
                ("--scenario", "three.toml"),
                ("three.toml", "drive.torque_N_m", "needs 2 values, has 3"),
            ),
            (SET, (*SET, "needs --scenario")),
            (("--scenario", "pd", "--scenario", "pd"), ("name", "pd", "no other experiment")),
        )
    ),
    *(
        (
            (*RUN, "--scenario", f"{name}.toml", "--out", "report"),
            ("name", name, "no other experiment"),
        )
        for name in RESERVED_NAMES
    ),
    ((*LINKS, "file/below/run.nc"), ("file/below", "cannot be written")),
    ((*RUN, "--out", "file/below/run.nc"), ("file/below", "cannot be written")),
    ((*LINKS, "there"), ("--out", "there", "folder")),
    ((*PAPER, "--model", "adams:arm", "--out", "new/run.nc"), ("model = 'adams:arm'",)),
    *(
        (words, ("--help",))
        for words in (
            *(("fly",), ("run", "--jobs", "0"), ("run", "--seed", "-1")),
            *(("simulate",), ("show",), ("run", "a", "b")),
        )
    ),
    ((*LUMPED, "--json", "a.json"), ("planets-apart", "joints[0].sun_mesh.", "planets = free")),
]


@pytest.mark.parametrize(
    ("arguments", "said"), REFUSED, ids=[" ".join(words) for words, _ in REFUSED]
)
def test_arguments_are_refused_in_one_line_and_nothing_is_written(
    crosscheck, tmp_path, monkeypatch, arguments, said
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there").mkdir()
    files = {"file": "mine", "three.toml": THREE_TORQUES}
    for name in RESERVED_NAMES:
        files[f"{name}.toml"] = SCENARIO.replace('name = "constant-torque"', f'name = "{name}"')
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    assert_one_line(crosscheck(*arguments), *said)
    assert {path.name for path in tmp_path.rglob("*")} == {*files, "there"}
    assert {name: (tmp_path / name).read_text() for name in files} == files


def test_a_scenario_cannot_take_the_name_of_an_experiment_on_energy(labelled):
    first = Experiment("pd", Case(labelled, load_scenario("pd"), usual_switches(labelled)))
    planned = {each.name for each in make_energy_experiments(labelled, first, 1e-5)}
    assert len(planned) == 4
    assert planned <= set(RESERVED_NAMES)


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


def test_the_papers_own_arm_may_have_free_planets(short):
    assert short("--set", "switches.planets=free").code == 0
    assert short("--set", "arm.joints.*.*_mesh.backlash_m=[5e-5, 4e-5, 5e-5]").code == 0
