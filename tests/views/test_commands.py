"""What commands print on a terminal of 80 columns, one snapshot for each kind of result."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from syrupy.assertion import SnapshotAssertion

import crosscheck
from crosscheck.cli import commands
from crosscheck.cli.app import build_commands
from crosscheck.run import CrossCheck
from crosscheck.runner.outcomes import Failure
from crosscheck.trial.input.loading import load_equations
from crosscheck.trial.tables.state_requests import TableTrial
from tests.baselines import short
from tests.processes import Command
from tests.robots.chains import BOB
from tests.tool.supplied import model_file
from tests.trial.other_tools.tables import judge_table, sheets_of, write_csv
from tests.views.plain import list_lines, mask_numbers

HELPS = [
    *("", "baseline", "cache", "baseline accept", "baseline check", "cache clear"),
    *(name for name in build_commands().commands if name not in ("baseline", "cache")),
]
DOUBTFUL = BOB.replace('ixx="', 'ixx="9')  # more than the sum of the others
STUDY = """
schema_version = 1
name = "study"
arm = "probe"
scenario = "pd"
spot_checks = 1
settings = { "scenario.duration_s" = 0.001 }
axes = [{ path = "arm.payload_mass_kg", kind = "list", values = [1.0, 1.5, 2.0] }]
quantities = [
    { kind = "peak", signal = "theta_ddot" },
    { kind = "crossing", signal = "theta", level = 3.0, side = "above" },
    { kind = "trajectories", signals = ["torque"] },
]
"""
HANGING = """
schema_version = 2
name = "hanging"
payload_mass_kg = 2.0
gravity_m_per_s2 = [9.81, 0.0]
joints = [{ kind = "direct", motor_mass_kg = 2.0, rotor_inertia_kg_m2 = 0.01 }]
links = [{ length_m = 0.5, com_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.1 }]
"""
FILES = {"bob.urdf": BOB, "doubtful.urdf": DOUBTFUL, "study.toml": STUDY, "hanging.toml": HANGING}
# A part of two_link's equations replaced: what is wrong with them by name.
EQUATIONS = """
def _replaced(arm, **parts):
    return replace(two_link(arm), **parts)

def half_a_term_too_much(arm):
    M, L1 = two_link(arm).mass_matrix, arm.links[0].length_m
    return _replaced(arm, mass_matrix=lambda q: np.add(M(q), [[0.5 * L1**2, 0], [0, 0]]))

def sign(arm):
    return _replaced(arm, force=lambda torque: -torque)

def raises(arm):
    def bad(q, v):
        raise ValueError("here")
    return _replaced(arm, bias=bad)

def mass_matrix_alone(arm):
    return Equations(mass_matrix=two_link(arm).mass_matrix)

def one_arm():
    from crosscheck import load_arm
    return two_link(load_arm("paper-labelled"))
"""
QUICK, LONG = "--quick --jobs 1", "--step 1e-3 --t-end 0.5 --out run.nc"
# Lines typed one after another, in a folder with the texts above as files.
LINES: dict[str, tuple[str, ...]] = {
    "list": ("list",),
    "show an arm": ("show probe",),
    "show an arm with a direct joint": ("show direct-between",),
    "show an arm of unlike planets": ("show planets-apart",),
    "show an arm that hangs": ("show hanging.toml",),
    "show a robot": ("show six-joint",),
    "show a robot with gears": ("show sliding",),
    "show a URDF": ("show bob.urdf", "show doubtful.urdf"),
    "init": ("init a.toml --joints 3", "init plain.toml --direct --joints 1"),
    "init of a URDF": ("init bob.toml --urdf bob.urdf",),
    "export": (
        "export probe --model analytic:links --out links.c",
        "export probe --model analytic:physical --out geared.c",
        "export sliding --model analytic:geared --out robot.c",
        "export probe --out probe.urdf",
    ),
    "simulate and view": (
        "simulate probe --model analytic:physical --scenario pd --t-end 0.001 --out run.nc",
        "simulate sliding --model analytic:coupled --scenario pd --t-end 0.001 --out robot.nc",
        "view run.nc",
    ),
    "simulate beyond stability": (
        f"simulate probe --model analytic:physical --scenario pd {LONG}",
        f"simulate probe --model analytic:physical --scenario pd {LONG} --force",
    ),
    "sweep and plot": (
        "sweep study.toml --out study.nc --jobs 1",
        "sweep study.toml --out study.nc --jobs 1",
        "sweep study.toml --out study.nc --jobs 1 --resume",
        "plot study.nc",
        "plot study.nc --quantity nothing",
    ),
    "cost without rotors": ("cost bob.urdf --quick",),
    "compare what is no record": ("compare study.toml", "compare nowhere.csv"),
    "cache": ("cache clear",),
    "ask": ("trial --ask probe --out asked --quick", "trial --ask sliding --out robot"),
    "trial, right": (f"trial mine.py:two_link {QUICK} --json t.json",),
    "trial, right on one arm alone": (f"trial mine.py:one_arm {QUICK}",),
    "trial of one part": (f"trial mine.py:mass_matrix_alone {QUICK}",),
    "trial, a term": (f"trial mine.py:half_a_term_too_much {QUICK}",),
    "trial, an exception": (f"trial mine.py:raises {QUICK}",),
}


@pytest.fixture
def terminal(
    crosscheck: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[..., str]:
    """``terminal(*lines)``: all that they print, with their exit codes, in a folder of files."""
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "folder").mkdir()
    monkeypatch.chdir(tmp_path / "folder")
    model_file(Path(), EQUATIONS)
    for name, text in FILES.items():
        Path(name).write_text(text, encoding="utf-8")

    def type_lines(*lines: str, masked: bool = False) -> str:
        shown = []
        for line in lines:
            code, out, err = crosscheck(*line.split())
            shown += [f"$ crosscheck {line}"]
            text = "\n".join(filter(None, (out.rstrip("\n"), err.rstrip("\n"))))
            shown += [mask_numbers(text) if masked else text] if text else []
            shown += [f"exit code {code}"] if code else []
        text = "\n".join(shown).replace(str(tmp_path), "...")
        return list_lines(re.sub(r"Usage: .*?crosscheck", "Usage: crosscheck", text))

    return type_lines


@pytest.mark.parametrize("command", HELPS)
def test_help(command: str, terminal: Callable[..., str], snapshot: SnapshotAssertion):
    assert terminal(f"{command} -h".strip()) == snapshot


@pytest.mark.parametrize("name", LINES)
def test_a_terminal(name: str, terminal: Callable[..., str], snapshot: SnapshotAssertion):
    masked = name.startswith(("trial", "sweep", "simulate"))
    assert terminal(*LINES[name], masked=masked) == snapshot


@pytest.mark.parametrize(
    "name",
    [f"a.toml --joints {n}" for n in (1, 7)]
    + [f"a.toml --direct --joints {n}" for n in (2, 7)]
    + ["bob.toml --urdf bob.urdf"],
)
def test_a_file_to_start_from(name: str, terminal: Callable[..., str], snapshot: SnapshotAssertion):
    terminal(f"init {name}")
    assert Path(name.split()[0]).read_text(encoding="utf-8") == snapshot


def red(result: CrossCheck) -> CrossCheck:
    """With a check that differs, and a run that is lost."""
    lost = short.with_run(result, short.ANALYTIC, Failure("RuntimeError", "no engine"))
    return short.with_findings(lost, [short.green(), short.red()])


RESULTS: dict[str, tuple[tuple[str, Callable[[CrossCheck], CrossCheck]], ...]] = {
    "validate": (("validate --quick --json a.json", lambda made: made),),
    "validate, red": (("validate --quick", red),),
    "run": (("run --quick", lambda made: made),),
    "baseline": (
        ("baseline check --quick", lambda made: made),
        ("baseline accept --quick", lambda made: made),
        ("baseline check --quick", lambda made: made),
        ("baseline check --quick", red),
    ),
    "baseline, red": (
        ("baseline accept --quick", red),
        ("baseline accept --quick --with-differences", red),
        ("baseline check --quick", red),
        ("baseline check --quick", lambda made: made),
    ),
    "baseline of nothing": (
        ("baseline accept --quick", lambda made: short.with_findings(made, [])),
    ),
}


@pytest.mark.parametrize("name", RESULTS)
def test_a_terminal_of_a_made_cross_check(
    name: str,
    terminal: Callable[..., str],
    labelled,
    monkeypatch: pytest.MonkeyPatch,
    snapshot: SnapshotAssertion,
):
    shown = []
    for line, change in RESULTS[name]:
        made = change(short.invented_check(labelled))
        monkeypatch.setattr(commands, "run_cross_check", lambda *_, made=made, **__: made)
        shown.append(terminal(line))
    assert "\n".join(shown) == snapshot


@pytest.mark.parametrize("name", ["two_link", "sign"])
def test_a_trial_of_a_table(name: str, labelled, tmp_path: Path, snapshot: SnapshotAssertion):
    """On the arm alone, as a first table of answers is."""
    file = model_file(tmp_path, EQUATIONS)
    equations = load_equations(f"{file}:{name}", labelled, None)
    table = TableTrial(labelled, equations.coordinates, equations.level, quick=True)
    answers = write_csv(tmp_path / "answers.csv", sheets_of(table, equations, probes=False))
    assert mask_numbers("\n".join(judge_table(table, answers).lines)) == snapshot


@pytest.mark.parametrize("model", ["analytic:physical", "pinocchio:coupled"])
def test_a_model_prints_itself(model: str, labelled, snapshot: SnapshotAssertion):
    assert repr(crosscheck.build(model, labelled, crosscheck.load_scenario("pd"))) == snapshot
