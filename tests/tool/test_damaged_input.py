"""Whatever files and options a command is given: exit code 0, 1 or 2, in time, in a few lines."""

import os
import random
import resource
import shutil
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np
import pytest
import scipy.io
import typer

from crosscheck.api import require_stable_step
from crosscheck.checks import engines
from crosscheck.cli.app import main
from crosscheck.cli.simulation import SimulationRequest
from crosscheck.models.errors import LONGEST_LINE
from crosscheck.models.files import HERE
from crosscheck.models.loading import load_arm
from crosscheck.provenance import ROOT
from crosscheck.registry import build
from tests.draws import DRAWS, SAMPLE, fresh_seed
from tests.measured.records import level, name_columns, record_of, write_table
from tests.tool.damage import PIECES, place_damaged
from tests.warm import become, import_all

MOST_LINES, WITHIN_S, MEMORY = 6, 100.0, 6_000_000_000
ROBOT = ["sliding.toml", "sliding.urdf"]
OWN_ROBOT = """
import numpy as np
from types import SimpleNamespace
def equations(robot):
    n = len(robot.coordinates)
    return SimpleNamespace(mass_matrix=lambda q: np.eye(n), gravity=lambda q: np.zeros(n))
"""
SETTINGS = "--set arm.?=?|--set scenario.?=?|--set switches.?=?|--set ?|--set arm.joints.?.?=?"
# Commands with the options of which some are given. A random piece stands for each question mark.
COMMANDS: dict[str, tuple[str, str]] = {
    "show": ("show arm.toml", ""),
    "show a MuJoCo file": ("show robot.xml", ""),
    "show a robot": ("show robot.toml", ""),
    "init": ("init ?.toml", "--urdf sliding.urdf|--joints ?|--direct"),
    "run": ("run arm.toml", "--scenario scenario.toml|--jobs ?|--seed ?|--out ?|--quick"),
    "validate": (
        "validate arm.toml --scenario scenario.toml",
        f"--json ?|--junit ?|--jobs ?|{SETTINGS}",
    ),
    "accept": ("baseline accept arm.toml --quick", "--dir ?|--junit ?|--jobs ?"),
    "baseline": ("baseline check --quick --dir records", "--junit j.xml|--jobs ?"),
    "simulate": (
        "simulate arm.toml --model analytic:physical --scenario scenario.toml --out out/a.nc",
        f"--t-end ?|--step ?|--model ?|--scenario ?|--out ?|--force|--rtol ?|{SETTINGS}",
    ),
    "export": (
        "export arm.toml --model analytic:links --out a.c",
        "--set arm.payload_mass_kg=?|--model analytic:?",
    ),
    "view": ("view run.nc", "--out ?"),
    "plot": ("plot study.nc", "--quantity ?|--out a.png"),
    "cost": ("cost sliding.toml --quick", "--seed ?|--json c.json"),
    "cost of a URDF": ("cost sliding.urdf --quick", "--out page"),
    "cost of a motion": ("cost sliding.toml --quick --motion motion.csv", ""),
    "compare": ("compare record.csv", "--json c.json|--tolerance arm.payload_mass_kg=?|--joint ?"),
    "compare a MAT file": ("compare record.mat", "--scenario ?"),
    "compare a run": ("compare run.nc", "--topic ?|--out page"),
    "trial of a robot": ("trial mine.py:equations sliding.toml", "--seed ?|--json t.json|--quick"),
    "trial of an FMU": (
        "trial unit.fmu probe --coordinates map.toml --run-code",
        "--scenario ?|--quick",
    ),
    "questions to an FMU": ("trial --ask unit.fmu --out asked", ""),
    "errata": ("errata arm.toml", "--json e.json"),
    "sweep": ("sweep study.toml --out new.nc", "--resume|--jobs ?|--run-code"),
}
LONG = ("view", "plot", "cost", "compare", "trial", "export")  # of which one is enough in the suite


class Ending(NamedTuple):
    """How a command ended: its exit code, None if it had to be ended; what it printed; its time."""

    code: int | None
    out: str
    err: str
    seconds: float


def run_apart(arguments: list[str], folder: Path) -> Ending:
    """Run a command in a fork of this process, in a folder."""
    streams = folder.with_suffix(".out"), folder.with_suffix(".err")
    child, began = os.fork(), time.monotonic()
    if child == 0:
        _become(arguments, folder, streams)
    code = None
    while time.monotonic() - began < WITHIN_S:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            code = os.waitstatus_to_exitcode(status)
            break
        time.sleep(0.005)
    with suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    if code is None:
        os.waitpid(child, 0)
    texts = (path.read_text(encoding="utf-8", errors="replace") for path in streams)
    return Ending(code, *texts, time.monotonic() - began)


def _become(arguments: list[str], folder: Path, streams: tuple[Path, Path]) -> NoReturn:
    try:
        own = {"arguments": arguments, "folder": str(folder), "environment": {**os.environ}}
        files = dict(zip(("out", "err"), map(str, streams), strict=True))
        become(own | files | {"largest": resource.RLIM_INFINITY})
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w", buffering=1)
        sys.__stdout__, sys.__stderr__ = sys.stdout, sys.stderr  # type: ignore[misc]
        main()
    except SystemExit as left:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(left.code if isinstance(left.code, int) else int(left.code is not None))
    finally:
        os._exit(99)


@cache
def _seeds(folder: Path) -> dict[str, Path]:
    """Sound files of every kind that commands read."""
    (folder / "records").mkdir()
    arm = HERE / "arms" / "probe.toml"
    copies = {
        "arm.toml": arm,
        **{name: HERE / "robots" / name for name in ROBOT},
        **{name: Path(__file__).with_name(name) for name in ("robot.toml", "robot.xml")},
        "scenario.toml": HERE / "scenarios" / "constant-torque.toml",
        "records/paper-labelled-quick.json": ROOT / "baselines" / "paper-labelled-quick.json",
        "study.toml": Path(__file__).with_name("study.toml"),
    }
    for name, source in copies.items():
        shutil.copyfile(source, folder / name)
    record = record_of(level(load_arm("paper-labelled"), "coupled"), time=0.01 * np.arange(300))
    columns = name_columns(record)
    scipy.io.savemat(folder / "record.mat", columns)
    write_table(folder / "record.csv", columns)
    time = record.time[:20]
    angles = {f"theta_{joint}_rad": 0.1 * np.sin(time) for joint in (1, 2, 3)}
    write_table(folder / "motion.csv", {"t_s": time, **angles})
    (folder / "mine.py").write_text(OWN_ROBOT)
    (folder / "mine_study.py").write_text("def f(run):\n    return {'last': run.theta[-1, 0]}\n")
    (folder / "map.toml").write_text(
        'q = ["theta_1", "theta_2"]\nv = ["v_theta_1", "v_theta_2"]\n'
        'torque = ["torque_1", "torque_2"]\n'
    )
    made = (
        "simulate probe --model analytic:physical --scenario constant-torque --t-end 0.01"
        " --out run.nc",
        "export probe --model analytic:links --out unit.fmu",
        "sweep study.toml --out study.nc --jobs 1 --run-code",
    )
    shutil.copyfile(folder / "mine_study.py", folder.parent / "mine_study.py")
    text = (folder / "study.toml").read_text().replace("mine.py:f", "mine_study.py:f")
    (folder / "study.toml").write_text(text)
    for line in made:
        ending = run_apart(line.split(), folder)
        assert ending.code == 0, ending
    return {str(p.relative_to(folder)): p for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def seeds(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Path]]:
    """Sound files; once they are made, robots have few states and runs, and arms are read alone."""
    import_all()  # once, and not by every command
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(engines, "RUNS", 1)
        found = _seeds(tmp_path_factory.mktemp("seeds"))
        for work in (
            *("audit.errata.command.simulate_errata", "cli.commands.run_cross_check"),
            *("cli.trial.run_trial", "cli.simulation.perform_all"),
            "studies.batches.run.perform_tasks",
        ):
            patch.setattr(f"crosscheck.{work}", _leave)
        yield found


def _leave(*tasks: object, **_: object) -> NoReturn:
    """In place of the work: of a simulation all but the run itself."""
    for task in tasks:
        if isinstance(task, list) and isinstance(task[0], SimulationRequest):
            mechanism, (scenario,), switches, _ = task[0].chosen
            model = build(task[0].model, mechanism, scenario, switches)
            if not task[0].force:
                require_stable_step(model)
    raise typer.Exit(0)


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_no_file_and_no_option_breaks_a_command(command, tmp_path, seeds):
    line, options = COMMANDS[command]
    names = _list_read(f"{line} {options}", seeds)
    count = 1 if DRAWS == SAMPLE and command.startswith(LONG) else DRAWS
    seed, broken, codes = fresh_seed(), [], []
    for number in range(count):
        generator = random.Random(f"{seed} {number}")
        folder = tmp_path / str(number)
        (folder / "records").mkdir(parents=True)
        unlucky = _place(names, seeds, folder, generator)
        given = _draw_words(line, options, generator)
        before = _list_files(folder)
        ending = run_apart(given, folder)
        codes.append(ending.code)
        if why := _find_fault(ending, _list_files(folder) - before):
            broken.append((number, why, given, unlucky, ending))
        else:
            shutil.rmtree(folder)
    message = "\n".join(map(str, broken))
    print(f"{command}: seed {seed}, {count} inputs, {sum(code == 0 for code in codes)} accepted")
    assert not broken, f"{len(broken)} of {count}, seed {seed}\n{message}"


def _list_read(words: str, seeds: dict[str, Path]) -> list[str]:
    """Names of the files that stand in a command, and in files of TOML that do."""
    named = [name for name in seeds if any(part in words for part in Path(name).parts)]
    texts = (seeds[name].read_text() for name in named if name.endswith(".toml"))
    inside = "".join(texts)
    return [name for name in seeds if name in named or name in inside]


def _place(
    names: list[str], seeds: dict[str, Path], folder: Path, generator: random.Random
) -> list[str]:
    unlucky = place_damaged([seeds[name] for name in names], folder, generator)
    for name in names:
        if "/" in name and os.path.lexists(folder / Path(name).name):
            os.replace(folder / Path(name).name, folder / name)
    return unlucky


def _draw_words(line: str, options: str, generator: random.Random) -> list[str]:
    """A command line with some of its options, a random piece for each question mark."""
    possible = [*filter(None, options.split("|"))]
    chosen = generator.sample(possible, min(len(possible), generator.choice((0, 0, 1, 2))))
    return [_draw_pieces(word, generator) for part in (line, *chosen) for word in part.split()]


def _draw_pieces(word: str, generator: random.Random) -> str:
    first, *others = word.split("?")
    pieces = [generator.choice(PIECES).decode("utf-8", "replace") for _ in others]
    return (first + "".join(map("".join, zip(pieces, others, strict=True)))).replace("\0", "")


def _list_files(folder: Path) -> set[Path]:
    """Every file below; a folder may have been made for one when another is refused."""
    return {path for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc"}


def _find_fault(ending: Ending, written: set[Path]) -> str:
    """What is wrong with an ending; nothing if it is as it should be."""
    if ending.code is None:
        return f"had not ended after {WITHIN_S} s"
    if ending.code not in (0, 1, 2):
        return f"exit code {ending.code}"
    if f'File "{ROOT}' in ending.err + ending.out:  # which a user's own error does not name
        return "a traceback"
    if ending.err.count("\n") > MOST_LINES:
        return f"{ending.err.count(chr(10))} lines on standard error"
    if ending.code != 2:
        return ""
    last = "".join(ending.err.splitlines()[-1:])
    if not last.startswith("crosscheck: ") or not last.isprintable() or len(last) > LONGEST_LINE:
        return "refused otherwise than by a short line"
    return f"wrote {written} and refused" if written else ""
