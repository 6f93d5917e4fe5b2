"""Whatever files and options a command is given: exit code 0, 1 or 2, in time, in a few lines."""

import os
import random
import resource
import shutil
import signal
import sys
import time
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np
import pytest
import scipy.io
import typer

from crosscheck.audit.errata import command as audit_command
from crosscheck.checks import engines
from crosscheck.cli import cost as cost_command
from crosscheck.cli.app import main
from crosscheck.cost.shortcuts import SamplingPlan
from crosscheck.models.files import HERE
from crosscheck.models.loading import load_arm
from crosscheck.provenance import ROOT
from tests.draws import DRAWS, SAMPLE, fresh_seed
from tests.measured.records import level, name_columns, record_of, write_table
from tests.tool.hostile import PIECES, place_damaged
from tests.warm import import_all

MOST_LINES, WITHIN_S, MEMORY = 6, 100.0, 6_000_000_000
COUNT = DRAWS if DRAWS != SAMPLE else 1  # of a command in the suite, which has not much time
ROBOT = ["sliding.toml", "sliding.urdf"]
OWN_ROBOT = """
import numpy as np
from types import SimpleNamespace
def equations(robot):
    n = len(robot.coordinates)
    return SimpleNamespace(mass_matrix=lambda q: np.eye(n), gravity=lambda q: np.zeros(n))
"""
# By command: the files that it reads, its arguments, and options of which some are given.
COMMANDS: dict[str, tuple[list[str], list[str], list[list[str]]]] = {
    "show": (["arm.toml"], ["show", "arm.toml"], []),
    "export": (
        ["arm.toml"],
        ["export", "arm.toml", "--model", "analytic:links", "--out", "a.c"],
        [["--set", "arm.payload_mass_kg=?"], ["--model", "analytic:?"]],
    ),
    "view": (["run.nc"], ["view", "run.nc"], [["--out", "?"]]),
    "plot": (["study.nc"], ["plot", "study.nc"], [["--quantity", "?"], ["--out", "a.png"]]),
    "init": (["sliding.urdf"], ["init", "new.toml", "--urdf", "sliding.urdf"], [["--joints", "?"]]),
    "cost": (ROBOT, ["cost", "sliding.toml", "--quick"], [["--seed", "?"], ["--json", "c.json"]]),
    "cost of a URDF": (ROBOT[1:], ["cost", "sliding.urdf", "--quick"], [["--out", "page"]]),
    "cost of a motion": (
        [*ROBOT, "motion.csv"],
        ["cost", "sliding.toml", "--quick", "--motion", "motion.csv"],
        [],
    ),
    "compare": (
        ["record.csv"],
        ["compare", "record.csv"],
        [["--json", "c.json"], ["--tolerance", "arm.payload_mass_kg=?"], ["--joint", "?"]],
    ),
    "compare a MAT file": (["record.mat"], ["compare", "record.mat"], [["--scenario", "?"]]),
    "compare a run": (["run.nc"], ["compare", "run.nc"], [["--topic", "?"], ["--out", "page"]]),
    "trial of a robot": (
        [*ROBOT, "mine.py"],
        ["trial", "mine.py:equations", "sliding.toml"],
        [["--seed", "?"], ["--json", "t.json"], ["--quick"]],
    ),
    "trial of an FMU": (
        ["unit.fmu", "map.toml"],
        ["trial", "unit.fmu", "probe", "--coordinates", "map.toml", "--run-code"],
        [["--scenario", "?"], ["--quick"]],
    ),
    "questions to an FMU": (["unit.fmu"], ["trial", "--ask", "unit.fmu", "--out", "asked"], []),
    "baseline": (
        ["records/paper-labelled-quick.json"],
        ["baseline", "check", "--quick", "--dir", "records"],
        [["--junit", "j.xml"], ["--jobs", "?"]],
    ),
    "errata": (["arm.toml"], ["errata", "arm.toml"], [["--json", "e.json"]]),
    "sweep": (
        ["study.toml", "arm.toml", "scenario.toml"],
        ["sweep", "study.toml", "--out", "new.nc"],
        [["--resume"], ["--jobs", "?"], ["--run-code"]],
    ),
}


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
        os.setsid()
        os.chdir(folder)
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        for descriptor, file in zip((1, 2), streams, strict=True):
            handle = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
            os.dup2(handle, descriptor)
        sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w", buffering=1)
        sys.__stdout__, sys.__stderr__ = sys.stdout, sys.stderr  # type: ignore[misc]
        sys.argv = ["crosscheck", *arguments]
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
def seeds(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    import_all()  # once, and not by every command
    return _seeds(tmp_path_factory.mktemp("seeds"))


@pytest.fixture(scope="module", autouse=True)
def short_work() -> object:
    """Robots are looked at in few states and runs; arms, once all is read, not at all."""

    def leave(*_: object, **__: object) -> NoReturn:
        raise typer.Exit(0)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cost_command, "QUICK", SamplingPlan(1, 3, 1, 10, 100))
        patch.setattr(engines, "RUNS", 1)
        patch.setattr(audit_command, "simulate_errata", leave)
        patch.setattr("crosscheck.cli.commands.run_cross_check", leave)
        patch.setattr("crosscheck.cli.trial.run_trial", leave)
        yield


@pytest.mark.campaign
@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_no_file_and_no_option_breaks_a_command(command, tmp_path, seeds):
    names, arguments, options = COMMANDS[command]
    seed, broken, codes = fresh_seed(), [], []
    for number in range(COUNT):
        generator = random.Random(f"{seed} {number}")
        folder = tmp_path / str(number)
        (folder / "records").mkdir(parents=True)
        unlucky = _place(names, seeds, folder, generator)
        given = [*arguments, *_drawn(options, generator)]
        ending = run_apart(given, folder)
        codes.append(ending.code)
        if why := _fault(ending):
            broken.append((number, why, given, unlucky, ending))
        else:
            shutil.rmtree(folder)
    told = "\n".join(map(str, broken))
    print(f"{command}: seed {seed}, {COUNT} inputs, {sum(code == 0 for code in codes)} accepted")
    assert not broken, f"{len(broken)} of {COUNT}, seed {seed}\n{told}"


def _place(
    names: list[str], seeds: dict[str, Path], folder: Path, generator: random.Random
) -> list[str]:
    unlucky = place_damaged([seeds[name] for name in names], folder, generator)
    for name in names:
        if "/" in name and os.path.lexists(folder / Path(name).name):
            os.replace(folder / Path(name).name, folder / name)
    return unlucky


def _drawn(options: list[list[str]], generator: random.Random) -> list[str]:
    """Some of the options, a random piece for each question mark."""
    given = []
    for option in options:
        if generator.random() < 0.25:
            piece = generator.choice(PIECES).decode("utf-8", "replace").replace("\0", "")
            given += [word.replace("?", piece) for word in option]
    return given


def _fault(ending: Ending) -> str:
    """What is wrong with an ending; nothing if it is as it should be."""
    if ending.code is None:
        return f"had not ended after {WITHIN_S} s"
    if ending.code not in (0, 1, 2):
        return f"exit code {ending.code}"
    if f'File "{ROOT}' in ending.err + ending.out:  # which a user's own error does not name
        return "a traceback"
    if ending.err.count("\n") > MOST_LINES:
        return f"{ending.err.count(chr(10))} lines on standard error"
    last = ending.err.splitlines()[-1:]
    if ending.code == 2 and not (last and last[0].startswith("crosscheck: ")):
        return "leaved without a line"
    return ""
