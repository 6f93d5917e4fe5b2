"""Every option of every command and its effect: two command lines whose results differ.

Work that takes long is replaced by a recorder of what it is asked, as deep below the command line
as possible; files and short runs are real.
"""

import json
import os
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib import import_module
from inspect import signature
from operator import attrgetter
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import click
import pytest
import xarray as xr

from crosscheck.cli.app import build_commands
from crosscheck.findings import Agreement
from crosscheck.models.errors import Unfinished
from crosscheck.models.loading import load_arm, load_case
from crosscheck.models.refusals import REFUSALS
from crosscheck.provenance import record_provenance
from crosscheck.registry import build
from crosscheck.run import CrossCheck
from crosscheck.trial.trial import make_cross_check_request
from tests.baselines.short import green, invented_check, red
from tests.processes import Answer, Command
from tests.robots.chains import BOB
from tests.studies.studies import RIGHT
from tests.tool.supplied import model_file
from tests.tool.test_bad_input import assert_one_line

CORES = 6
ODD_KG = 99.0  # of a payload with which a check differs
RTOL = 1e-6
STUDY = RIGHT.read_text(encoding="utf-8")
FUNCTION = 'kind = "user_function"\nfunction = "mine.py:f"\nreturns = { a = "m" }'
FILES = {
    "map.toml": "matrix = [[1, 0], [1, 1]]\n",
    **{f"{name}.toml": STUDY.replace('"bad"', f'"{name}"') for name in ("one", "two")},
    "code.toml": STUDY.replace('kind = "peak"\nsignal = "theta_ddot"', FUNCTION),
    "bob.urdf": BOB,
    "u.fmu": "no unit",
}


class Observed(NamedTuple):
    """What a command did: its answer, what work was asked, new files, pages that it opened."""

    answer: Answer
    asked: dict[str, SimpleNamespace]
    files: dict[str, Path]
    opened: list[str]


class Effect(NamedTuple):
    """Two command lines, how they are looked at, and what is seen of each, if that matters.

    before: a command that runs first, of a check of records the one that records; real: the work
    is done.
    """

    lines: tuple[str, str]
    see: str
    seen: tuple[Any, Any] | None
    before: str
    real: bool


TABLE = tomllib.loads(Path(__file__).with_name("options.toml").read_text(encoding="utf-8"))
USUAL = {"arm": "paper-labelled", "model": "analytic:physical", "scenario": "constant-torque"}
OF_CHECKS = {name: TABLE["run"][name] for name in ("scenario", "settings", "quick", "jobs", "arm")}
INHERITED = {
    "validate": OF_CHECKS | {"seed": TABLE["run"]["seed"]},
    "baseline accept": OF_CHECKS,
    "baseline check": OF_CHECKS,
}


def read_effect(command: str, name: str, row: dict[str, Any]) -> Effect:
    """A row of the table: of an option that is added, or of another word at a place."""
    line = row.get("line", TABLE[command].get("line", command))
    usual = USUAL | {"out": "o.nc"}
    if "word" in row:
        lines = tuple(line.format(each, **(usual | {name: each})) for each in row["word"])
    else:
        line = line.format(**usual)
        lines = line, row.get("other", f"{line} {row.get('more')}")
    seen = row.get("seen", row.get("word"))
    return Effect(lines, row["see"], seen and tuple(seen), row.get("before", ""), "real" in row)


EFFECTS = {
    command: {
        name: read_effect(command, name, row)
        for name, row in (INHERITED.get(command, {}) | rows).items()
        if name != "line"
    }
    for command, rows in TABLE.items()
}
DONE: dict[tuple[str, str], Observed] = {}  # command lines whose work was done, and the one before


def stop(**given: object) -> None:
    """Work that is asked for and not done."""
    raise Unfinished("recorded")


def make_check(request: Any, **given: object) -> CrossCheck:
    """A cross-check by no engine; for an arm of ODD_KG a check differs."""
    finding = red() if request.mechanism.payload_mass_kg == ODD_KG else green()
    asked = request.mechanism, request.seed, request.quick, request.scenarios, request.chosen
    agreement = Agreement([finding], record_provenance(*asked, model=request.model))
    return replace(invented_check(request.mechanism), request=request, agreement=agreement)


def make_trial(request: Any, **given: object) -> SimpleNamespace:
    """A trial by no engine."""
    return SimpleNamespace(cross_check=make_check(make_cross_check_request(request)))


def make(value: object) -> Callable[..., object]:
    return lambda **given: value


CHECK = {"cli.commands.run_cross_check": make_check}
WORK: dict[str, dict[str, Callable[..., object]]] = {
    "run": CHECK,
    "validate": CHECK,
    "baseline": {**CHECK, "cli.trial.run_trial": make_trial},
    "trial": {
        "cli.trial.run_trial": stop,
        "cli.trial.read_trial_answers": stop,
        "cli.trial.collect_state_request": stop,
    },
    "compare": {
        "cli.compare.read_record": make(SimpleNamespace(motor_torque=0.0)),
        "cli.compare.check_rates": make(None),
        "cli.compare.add_drive_torques": make(SimpleNamespace(motor_torque=0.0)),
        "cli.compare.compare": make(
            SimpleNamespace(engines_agree=True, is_decided=True, excitation=None)
        ),
        "cli.compare.describe_comparison": make([]),
        "cli.compare.comparison_json": make("JSON"),
        "cli.compare.comparison_page": make("page"),
    },
    "cost": {
        "cli.cost.read_record": make("record"),
        "cli.cost.fit_motion": make("motion"),
        "cli.cost.compute_costs": make(SimpleNamespace(agrees=True)),
        "cli.cost.describe_result": make([]),
        "cli.cost.cost_json": make("JSON"),
        "cli.cost.cost_page": make("page"),
    },
    "sweep": {"cli.studies.run_study": stop},
    "plot": {"cli.studies.use_file": make(b"picture")},
    "view": {"cli.view.read_run": make("run"), "cli.view.view_page": make("page")},
    "errata": {"audit.errata.command.simulate_errata": make([])},
    "paper": {
        "audit.page.report.write_paper": stop,
        "audit.page.report.write_figures": stop,
        "audit.judging.paper_folder.run_folder_command": stop,
    },
}


def find_jobs(seen: Observed) -> int:
    """Of whatever is asked with a number of processes."""
    (given,) = seen.asked.values()
    return getattr(given, "jobs", 0) or given.request.jobs


def find_scenarios(seen: Observed) -> list[str]:
    """Names of the experiments that a request is of."""
    (given,) = seen.asked.values()
    return [each.name for each in given.request.scenarios]


def find_drives(seen: Observed) -> list[str]:
    """Names of the scenarios that any work is asked with."""
    return [each.scenario.name for each in seen.asked.values() if hasattr(each, "scenario")]


def read_contents(seen: Observed) -> dict[str, str]:
    return {name: path.read_text() for name, path in seen.files.items()}


def read_run(seen: Observed) -> Any:
    (file,) = seen.files.values()
    with xr.open_dataset(file, engine="h5netcdf", decode_times=False) as run:
        return run.load()


def is_precise(seen: Observed) -> bool:
    """Whether a run is bit for bit the model's own at RTOL."""
    case = load_case("paper-labelled", "constant-torque", {}, ["scenario.duration_s=0.002"])
    return bool(
        (build("analytic:physical", *case).precise(RTOL).theta == read_run(seen).theta).all()
    )


def find_torques(seen: Observed) -> list[float]:
    data = json.loads(seen.files["j"].read_text())
    return [joint["largest_torque"] for joint in data["joints"]]


SEES: dict[str, Callable[[Observed], Any]] = {
    "files": lambda seen: sorted(seen.files),
    "contents": read_contents,
    "code": lambda seen: seen.answer.code,
    "called": lambda seen: sorted(seen.asked),
    "opened": lambda seen: [each.removeprefix(f"{Path.cwd().as_uri()}/") for each in seen.opened],
    "jobs": find_jobs,
    "scenarios": find_scenarios,
    "drives": find_drives,
    "precise": is_precise,
    "is long": lambda seen: len(seen.answer.out) > 2000,
    "largest torques": find_torques,
    "rotor.ratio": lambda seen: seen.asked["compute_costs"].robot.rotors[0].ratio,
    "rotor.inertia": lambda seen: seen.asked["compute_costs"].robot.rotors[0].inertia,
    "map": lambda seen: seen.asked["collect_state_request"].trial.coordinates.matrix is not None,
    "joints of a.toml": lambda seen: [
        joint.kind for joint in load_arm(str(seen.files["a.toml"])).joints
    ],
    "run end": lambda seen: pytest.approx(float(read_run(seen).time[-1])),
    "run step_s": lambda seen: float(read_run(seen).attrs["step_s"]),
    "run model": lambda seen: read_run(seen).attrs["model"],
}


def look(see: str, seen: Observed) -> Any:
    """What a word of the table sees: a run's record, words or files, or what work is asked with."""
    if see in SEES:
        return SEES[see](seen)
    sort, _, what = see.partition(" ")
    if sort == "run":
        record, _, field = what.partition(".")
        return json.loads(read_run(seen).attrs[record])[field]
    if sort == "has" and what.startswith("in "):
        file, _, words = what.removeprefix("in ").partition(": ")
        return words in read_contents(seen)[file]
    if sort == "has" and what.startswith("file "):
        return what.removeprefix("file ") in seen.files
    if sort == "has":
        return what in seen.answer.out + seen.answer.err
    work, _, argument = see.partition(".")
    found = attrgetter(argument)(seen.asked[work])
    if isinstance(found, tuple | list):
        return [str(each) if isinstance(each, Path) else each for each in found]
    return str(found) if isinstance(found, Path | None) else found


REFUSING = {
    "simulate": "simulate sliding --model analytic:links --scenario pd --out o.nc",
    "trial": "trial mine.py:two_link sliding",
    "trial --after": "trial --ask sliding --out o",
    "init": "init a.toml --urdf bob.urdf",
}
VALUES = {"--scenario": "pd", "--after": "r", "--joints": "2", "--direct": "", "--run-code": ""}
TYPERS_OWN = {"install_completion", "show_completion"}


def list_parameters(command: Any, words: tuple[str, ...] = ()) -> Iterator[tuple[str, str]]:
    """Every parameter of a command and of those in it, as the parser itself has them."""
    for parameter in command.params:
        if parameter.name not in TYPERS_OWN:
            yield " ".join(words), parameter.name
    if isinstance(command, click.Group) or hasattr(command, "commands"):
        for name, each in command.commands.items():
            yield from list_parameters(each, (*words, name))


def test_the_table_has_every_option_of_every_command():
    stated_here = {(command, name) for command, rows in EFFECTS.items() for name in rows}
    assert stated_here == set(list_parameters(build_commands()))


REFUSED = [each for each in REFUSALS if each.option.startswith("--")]


def test_every_option_that_one_sort_of_mechanism_does_not_take_is_refused():
    assert {each.option for each in REFUSED} == set(VALUES)


@pytest.mark.parametrize("refusal", REFUSED, ids=str)
def test_what_one_sort_of_mechanism_does_not_take_is_one_line(
    crosscheck, tmp_path, monkeypatch, refusal
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bob.urdf").write_text(BOB)
    words = REFUSING.get(f"{refusal.command} {refusal.option}", REFUSING[refusal.command])
    value = VALUES[refusal.option]
    answer = crosscheck(*words.split(), refusal.option, *filter(None, [value]))
    assert_one_line(answer, f"{refusal.option}: is for arms: {refusal.reason}")
    assert [path.name for path in tmp_path.iterdir()] == ["bob.urdf"]


@pytest.fixture
def observe(
    crosscheck: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[..., list[object]]:
    """``observe(effect, command)``: what is seen of both command lines, each in its own folder."""
    pages, work = list[str](), dict[str, SimpleNamespace]()
    monkeypatch.setattr(os, "cpu_count", lambda: CORES)
    monkeypatch.setattr("webbrowser.open", pages.append)

    def record(target: str, answer: Callable[..., object]) -> None:
        module, _, name = f"crosscheck.{target}".rpartition(".")
        parameters = signature(getattr(import_module(module), name))

        def recorder(*given: object, **named: object) -> object:
            bound = parameters.bind(*given, **named)
            bound.apply_defaults()
            work[name] = SimpleNamespace(**bound.arguments)
            return answer(**bound.arguments)

        monkeypatch.setattr(f"{module}.{name}", recorder)

    def run(words: str, before: str) -> Observed:
        if words.startswith("baseline check"):
            before = before or words.replace("check", "accept", 1)
        folder = tmp_path / str(len(list(tmp_path.iterdir())))
        folder.mkdir()
        for name, text in FILES.items():
            (folder / name).write_text(text)
        other = "def other(arm):\n    return two_link(arm)\n\ndef f(run):\n    return {'a': 0.0}\n"
        model_file(folder, other)
        monkeypatch.chdir(folder)
        if before:
            assert crosscheck(*before.split()).code == 0
        there = set(folder.rglob("*"))
        pages.clear()
        work.clear()
        answer = crosscheck(*words.split())
        made = {str(each.relative_to(folder)): each for each in set(folder.rglob("*")) - there}
        files = {name: path for name, path in made.items() if path.is_file()}
        return Observed(answer, dict(work), files, list(pages))

    def observe(effect: Effect, command: str) -> list[object]:
        recorded = {} if effect.real else WORK.get(command.partition(" ")[0], {})
        for target, answer in recorded.items():
            record(target, answer)
        done = {} if recorded else DONE
        found = []
        for words in effect.lines:
            if (words, effect.before) not in done:
                done[words, effect.before] = run(words, effect.before)
            found.append(look(effect.see, done[words, effect.before]))
        return found

    return observe


@pytest.mark.parametrize(
    ("command", "parameter"), [(each, name) for each, rows in EFFECTS.items() for name in rows]
)
def test_every_option_has_its_effect(observe, command, parameter):
    effect = EFFECTS[command][parameter]
    values = observe(effect, command)
    assert values[0] != values[1]
    assert effect.seen is None or values == list(effect.seen)
