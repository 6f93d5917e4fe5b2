"""Every option of every command and its effect: two command lines whose results differ.

Work that takes long is replaced by a recorder of what it is asked, as deep below the command line
as possible; files and short runs are real.
"""

import json
import os
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
from crosscheck.cost.shortcuts import FULL, QUICK
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
from tests.tool.supplied import model_file
from tests.tool.test_bad_input import assert_one_line

CORES = 6
PAPER_KG = 10.0
ODD_KG = 99.0  # of a payload with which a check differs
RTOL = 1e-6
SET = "--set arm.payload_mass_kg=3"
ANOTHER = object()  # a value that must differ, and may be any
STUDY = """\
schema_version = 1
name = "{name}"
arm = "paper-labelled"
scenario = "pd"
settings = {{ "scenario.duration_s" = 0.001 }}
quantities = [{{ {quantity} }}]
"""
FILES = {
    "map.toml": "matrix = [[1, 0], [1, 1]]\n",
    "one.toml": STUDY.format(name="one", quantity='kind = "peak", signal = "theta"'),
    "two.toml": STUDY.format(name="two", quantity='kind = "peak", signal = "theta"'),
    "code.toml": STUDY.format(
        name="code",
        quantity='kind = "user_function", function = "mine.py:f", returns = { a = "m" }',
    ),
    "bob.urdf": BOB,
    "u.fmu": "no unit",
}


class Observed(NamedTuple):
    """What a command did: its answer, what work was asked, new files, pages that it opened."""

    answer: Answer
    asked: dict[str, SimpleNamespace]
    files: dict[str, Path]
    opened: list[str]


See = Callable[[Observed], object]
DONE: dict[tuple[str, str], Observed] = {}  # command lines whose work was done, and the one before


class Effect(NamedTuple):
    """Two command lines, what of them is looked at, and its values.

    before: a command that runs first, of a check of records the one that records; real: the work
    is done.
    """

    usual: str
    other: str
    see: See
    values: tuple[object, object]
    before: str = ""
    real: bool = False


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


def asks(name: str, argument: str) -> See:
    """An argument that a function of WORK is asked with, or a field of one."""
    return lambda seen: attrgetter(argument)(seen.asked[name])


def asks_path(name: str, argument: str) -> See:
    return lambda seen: str(getattr(seen.asked[name], argument))


def called(seen: Observed) -> list[str]:
    return sorted(seen.asked)


def new_files(seen: Observed) -> set[str]:
    return set(seen.files)


def contents(seen: Observed) -> dict[str, str]:
    return {name: path.read_text() for name, path in seen.files.items()}


def opened(seen: Observed) -> list[str]:
    return [page.removeprefix(f"{Path.cwd().as_uri()}/") for page in seen.opened]


def says(words: str) -> See:
    return lambda seen: words in seen.answer.out + seen.answer.err


def code(seen: Observed) -> int:
    return seen.answer.code


def word(command: str, one: str, other: str, see: See) -> Effect:
    """Another word at a place of a command, which is what is seen."""
    return Effect(command.format(one), command.format(other), see, (one, other))


def options(words: str, **rows: tuple[Any, ...]) -> dict[str, Effect]:
    """Options of a command: how each is given, what is looked at, its values without and with."""
    return {name: option(words, *row) for name, row in rows.items()}


def of_requests(command: str, work: str, end: str = "") -> dict[str, Effect]:
    """Options of all that is asked by a request to cross-check; end: the command's last word."""
    return options(
        f"{command}{end}",
        scenario=(
            "--scenario pd --scenario back-and-forth",
            lambda seen: [each.name for each in seen.asked[work].request.scenarios],
            [],
            ["pd", "back-and-forth"],
        ),
        settings=(SET, asks(work, "request.mechanism.payload_mass_kg"), PAPER_KG, 3.0),
        quick=("--quick", asks(work, "request.quick"), False, True),
        jobs=("--jobs 3", lambda seen: find_jobs(seen.asked[work]), CORES, 3),
    )


def find_jobs(given: SimpleNamespace) -> int:
    return getattr(given, "jobs", 0) or given.request.jobs


def of_checks(command: str) -> dict[str, Effect]:
    arm = asks("run_cross_check", "request.mechanism.name")
    return {
        **of_requests(command, "run_cross_check"),
        "arm": option(command, "probe", arm, "paper-labelled", "probe"),
    }


def seed(work: str) -> tuple[object, ...]:
    return "--seed 4", asks(work, "request.seed"), 0, 4


def run_of(seen: Observed) -> Any:
    (file,) = seen.files.values()
    with xr.open_dataset(file, engine="h5netcdf", decode_times=False) as run:
        return run.load()


def stated(record: str, *path: str) -> See:
    """A value of the records in a run's attributes."""

    def pick(seen: Observed) -> object:
        value: Any = json.loads(run_of(seen).attrs[record])
        for key in path:
            value = value[key]
        return value

    return pick


def is_precise(seen: Observed) -> bool:
    """Whether a run is bit for bit the model's own at RTOL."""
    case = load_case("paper-labelled", "constant-torque", {}, ["scenario.duration_s=0.002"])
    return bool((build("analytic:physical", *case).precise(RTOL).theta == run_of(seen).theta).all())


def list_drives(seen: Observed) -> list[str]:
    """Names of the scenarios that any work is asked with."""
    return [each.scenario.name for each in seen.asked.values() if hasattr(each, "scenario")]


def kinds_of_joints(seen: Observed) -> list[str]:
    return [joint.kind for joint in load_arm(str(seen.files["a.toml"])).joints]


def largest_torques(seen: Observed) -> list[float]:
    data = json.loads(seen.files["j"].read_text())
    return [joint["largest_torque"] for joint in data["joints"]]


SIMULATE = "simulate {arm} --model {model} --scenario {scenario} --out {out} --t-end 0.002"
USUAL = {"arm": "paper-labelled", "model": "analytic:physical", "scenario": "constant-torque"}


def simulate(more: str = "", **other: str) -> str:
    return f"{SIMULATE.format_map({**USUAL, 'out': 'o.nc', **other})} {more}"


def simulation(see: See, *values: object, more: str = "", **other: str) -> Effect:
    return Effect(simulate(), simulate(more, **other), see, values)


def option(command: str, more: str, see: See, *values: object, real: bool = False) -> Effect:
    """An option that is left out and given."""
    return Effect(command, f"{command} {more}", see, values, real=real)


TRIAL, ASK = "trial mine.py:two_link", "trial --ask --out o"
EXPORT = "export probe --model analytic:links --out a.c"


def of_records(command: str) -> dict[str, Effect]:
    model, equations = "run_cross_check", "--model mine.py:two_link"
    return {
        **of_checks(command),
        "model": option(command, equations, called, [model], ["run_trial"]),
        "junit": option(command, "--junit k", lambda seen: "k" in seen.files, False, True)._replace(
            before="baseline accept"
        ),
    }


WRITTEN = option(
    *(f"{TRIAL} --quick", "--json j --junit k --out o", new_files),
    *(set(), {"j", "k", "o/trial.html"}),
    real=True,
)
EFFECTS: dict[str, dict[str, Effect]] = {
    "": {"version": Effect("list", "--version", says("paper-labelled"), (True, False))},
    "run": of_checks("run")
    | options(
        "run",
        seed=seed("run_cross_check"),
        out=(
            "--out o",
            new_files,
            {"report/index.html", "report/agreement.json"},
            {"o/index.html", "o/agreement.json"},
        ),
        open_page=("--open", opened, [], ["report/index.html"]),
    ),
    "validate": of_checks("validate")
    | options(
        "validate",
        seed=seed("run_cross_check"),
        json_file=("--json j", new_files, set(), {"j"}),
        junit=("--junit k", new_files, set(), {"k"}),
    ),
    "baseline accept": {
        **of_records("baseline accept"),
        "folder": option(
            "baseline accept",
            "--dir b",
            new_files,
            {"baselines/paper-labelled-full.json"},
            {"b/paper-labelled-full.json"},
        ),
        "with_differences": option(
            f"baseline accept --set arm.payload_mass_kg={ODD_KG}", "--with-differences", code, 1, 0
        ),
    },
    "baseline check": {
        **of_records("baseline check"),
        "folder": option("baseline check", "--dir b", code, 2, 0)._replace(
            before="baseline accept --dir b"
        ),
    },
    "simulate": {
        "arm": simulation(stated("arm", "name"), "paper-labelled", "probe", arm="probe"),
        "model": simulation(
            lambda seen: run_of(seen).attrs["model"],
            *("analytic:physical", "analytic:coupled"),
            model="analytic:coupled",
        ),
        "scenario": simulation(stated("scenario", "name"), "constant-torque", "pd", scenario="pd"),
        "out": simulation(new_files, {"o.nc"}, {"other.nc"}, out="other.nc"),
        "t_end": simulation(
            lambda seen: float(run_of(seen).time[-1]),
            *(pytest.approx(0.002), pytest.approx(0.001)),
            more="--t-end 0.001",
        ),
        "step": simulation(
            lambda seen: float(run_of(seen).attrs["step_s"]), 1e-5, 2e-5, more="--step 2e-5"
        ),
        "settings": simulation(stated("arm", "payload_mass_kg"), PAPER_KG, 3.0, more=SET),
        "force": Effect(simulate("--step 2e-4"), simulate("--step 2e-4 --force"), code, (2, 0)),
        "rtol": simulation(is_precise, False, True, more=f"--rtol {RTOL}"),
    },
    "trial": {
        **of_requests("trial", "run_trial", " mine.py:two_link"),
        "model": word(
            "trial {}", "mine.py:two_link", "mine.py:other", asks("run_trial", "request.name")
        ),
        **options(
            TRIAL,
            arm=("probe", asks("run_trial", "request.mechanism.name"), "paper-labelled", "probe"),
            seed=seed("run_trial"),
        ),
        **dict.fromkeys(("json_file", "junit", "out"), WRITTEN),
        "ask": Effect(TRIAL, ASK, called, (["run_trial"], ["collect_state_request"])),
        "answers": Effect(
            "trial --answers p",
            "trial --answers p --answers q",
            lambda seen: [str(each) for each in seen.asked["read_trial_answers"].paths],
            (["p"], ["p", "q"]),
        ),
        "after": option(
            ASK, "--after r", called, ["collect_state_request"], ["read_trial_answers"]
        ),
        "coordinates": option(
            ASK,
            "--coordinates map.toml",
            lambda seen: seen.asked["collect_state_request"].trial.coordinates.matrix is None,
            True,
            False,
        ),
        "run_code": option(
            "trial u.fmu --coordinates map.toml", "--run-code", says("--run-code"), True, False
        ),
    },
    "compare": {
        "record": word("compare {}", "r.csv", "s.mat", asks_path("read_record", "path")),
        **options(
            "compare r.csv",
            arm=("probe", asks("compare", "mechanism.name"), "paper-labelled", "probe"),
            scenario=("--scenario pd", list_drives, [], ["pd"]),
            settings=(SET, asks("compare", "mechanism.arm.payload_mass_kg"), PAPER_KG, 3.0),
            tolerance=(
                "--tolerance arm.payload_mass_kg=0.02",
                asks("compare", "tolerances"),
                {},
                {"arm.payload_mass_kg": 0.02},
            ),
            topic=("--topic t", asks("read_record", "topic"), "", "t"),
            joint=("--joint x --joint y", asks("read_record", "named"), [], ["x", "y"]),
            json_file=("--json j", contents, {}, {"j": "JSON"}),
            out=("--out o", contents, {}, {"o/compare.html": "page"}),
        ),
    },
    "cost": {
        "robot": word("cost {}", "sliding", "puma560", asks("compute_costs", "robot.name")),
        "ratio": option(
            "cost bob.urdf --rotor-inertia 1e-4 --ratio 7",
            "--ratio 9",
            lambda seen: seen.asked["compute_costs"].robot.rotors[0].ratio,
            7.0,
            9.0,
        ),
        "rotor_inertia": option(
            "cost bob.urdf --ratio 9 --rotor-inertia 1e-4",
            "--rotor-inertia 2e-4",
            lambda seen: seen.asked["compute_costs"].robot.rotors[0].inertia,
            1e-4,
            2e-4,
        ),
        "seed": option(
            "cost sliding --quick --json j",
            "--seed 4",
            largest_torques,
            ANOTHER,
            ANOTHER,
            real=True,
        ),
        **options(
            "cost sliding",
            motion=("--motion m.csv", asks("compute_costs", "given"), None, "motion"),
            quick=("--quick", asks("compute_costs", "extent"), FULL, QUICK),
            json_file=("--json j", contents, {}, {"j": "JSON"}),
            out=("--out o", contents, {}, {"o/cost.html": "page"}),
        ),
    },
    "export": {
        "arm": Effect(
            EXPORT.replace("probe", "paper-labelled"),
            EXPORT,
            lambda seen: "probe" in contents(seen)["a.c"],
            (False, True),
        ),
        "out": Effect(EXPORT, EXPORT.replace("a.c", "b.c"), new_files, ({"a.c"}, {"b.c"})),
        "model": Effect(
            EXPORT,
            EXPORT.replace(":links", ":physical"),
            lambda seen: "x_sp" in contents(seen)["a.c"],
            (False, True),
        ),
        "settings": option(EXPORT, SET, contents, ANOTHER, ANOTHER),
    },
    "sweep": {
        "study": word(
            "sweep {}.toml --out o.nc", "one", "two", asks("run_study", "study.definition.name")
        ),
        "out": word("sweep one.toml --out {}", "o.nc", "p.nc", asks_path("run_study", "out")),
        **options(
            "sweep one.toml --out o.nc",
            jobs=("--jobs 3", asks("run_study", "settings.jobs"), CORES, 3),
            resume=("--resume", asks("run_study", "settings.resume"), False, True),
        ),
        "run_code": option("sweep code.toml --out o.nc", "--run-code", called, [], ["run_study"]),
    },
    "plot": {
        "file": Effect("plot f.nc", "plot g.nc", new_files, ({"f.png"}, {"g.png"})),
        **options(
            "plot f.nc",
            quantity=(
                "--quantity a --quantity b",
                asks("use_file", "use.args"),
                ([],),
                (["a", "b"],),
            ),
            out=("--out o.png", new_files, {"f.png"}, {"o.png"}),
        ),
    },
    "view": {
        "file": Effect("view f.nc", "view g.nc", new_files, ({"f.html"}, {"g.html"})),
        **options(
            "view f.nc",
            out=("--out o.html", new_files, {"f.html"}, {"o.html"}),
            open_page=("--open", opened, [], ["f.html"]),
        ),
    },
    "list": {},
    "init": {
        "file": Effect("init a.toml", "init b.toml", new_files, ({"a.toml"}, {"b.toml"})),
        **options(
            "init a.toml",
            joints=("--joints 3", kinds_of_joints, ["planetary"] * 2, ["planetary"] * 3),
            direct=("--direct", kinds_of_joints, ["planetary"] * 2, ["direct"] * 2),
            urdf=(
                "--urdf bob.urdf",
                lambda seen: 'urdf = "bob.urdf"' in contents(seen)["a.toml"],
                False,
                True,
            ),
        ),
    },
    "show": {"arm": Effect("show probe", "show sliding", says("Robot sliding"), (False, True))},
    "cache clear": {},
    "errata": options(
        "errata",
        arm=(
            "paper-swapped",
            asks("simulate_errata", "arm.name"),
            "paper-labelled",
            "paper-swapped",
        ),
        json_file=("--json j", new_files, set(), {"j"}),
        out=("--out o", new_files, set(), {"o/errata.html"}),
        whole=("--all", lambda seen: len(seen.answer.out) > 2000, False, True),
    ),
    "paper": {
        **options(
            "paper",
            folder=("f", called, ["write_paper"], ["run_folder_command"]),
            figure=("--figure 8 --figure 9", called, ["write_paper"], ["write_figures"]),
            out=("--out o", asks_path("write_paper", "out"), "paper-report", "o"),
            first_seed=("--first-seed 4", asks("write_paper", "scale.first_seed"), 1, 4),
            jobs=("--jobs 3", asks("write_paper", "study.jobs"), CORES, 3),
        ),
        "run_code": option(
            "paper f", "--run-code", asks("run_folder_command", "run_code"), False, True
        ),
    },
}
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
        for words in (effect.usual, effect.other):
            if (words, effect.before) not in done:
                done[words, effect.before] = run(words, effect.before)
            found.append(effect.see(done[words, effect.before]))
        return found

    return observe


@pytest.mark.parametrize(
    ("command", "parameter"), [(each, name) for each, rows in EFFECTS.items() for name in rows]
)
def test_every_option_has_its_effect(observe, command, parameter):
    effect = EFFECTS[command][parameter]
    values = observe(effect, command)
    assert values[0] != values[1]
    for value, right in zip(values, effect.values, strict=True):
        assert right is ANOTHER or value == right
