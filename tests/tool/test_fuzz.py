"""No input breaks the program: it is accepted, or refused in one line with nothing written."""

import random
import sys
from pathlib import Path

import pytest
import typer

from crosscheck.api import require_stable_step
from crosscheck.cli.app import main
from crosscheck.cli.simulation import SimulationRequest
from crosscheck.models.errors import LONGEST_LINE
from crosscheck.registry import build
from tests.draws import DRAWS, fresh_seed
from tests.tool.fuzz import Draw, draw

# What each command does once its input is accepted; none of it is done here, nor a study's batches.
WORK = {
    "run": "crosscheck.cli.commands.run_cross_check",
    "validate": "crosscheck.cli.commands.run_cross_check",
    "baseline accept": "crosscheck.cli.commands.run_cross_check",
    "baseline check": "crosscheck.cli.commands.run_cross_check",
    "simulate": "crosscheck.cli.simulation.perform_all",
    "errata": "crosscheck.audit.errata.command.simulate_errata",
    "sweep": None,
    "show": None,
    "show MJCF": None,
    "trial FMU": None,
    "init": None,
}


def accepted(*tasks: object, **_: object) -> None:
    """In place of the work: of a simulation all but the run itself."""
    for task in tasks:
        if isinstance(task, list) and isinstance(task[0], SimulationRequest):
            mechanism, (scenario,), switches, _ = task[0].chosen
            model = build(task[0].model, mechanism, scenario, switches)
            if not task[0].force:
                require_stable_step(model)
    raise typer.Exit(0)


def files(folder: Path) -> set[Path]:
    """Every file below; a folder may have been made for one when another is refused."""
    return {path for path in folder.rglob("*") if path.is_file()}


def left(given: Draw, monkeypatch: pytest.MonkeyPatch) -> object:
    """The exit code of a command line."""
    monkeypatch.setattr(sys, "argv", ["crosscheck", *given.arguments])
    with pytest.raises(SystemExit) as end:
        main()
    return end.value.code


@pytest.mark.campaign
@pytest.mark.parametrize("command", WORK)
def test_any_input_is_accepted_or_refused_in_one_line(command, tmp_path, monkeypatch, capfd):
    work = WORK[command]
    if work is not None:
        monkeypatch.setattr(work, accepted)
    monkeypatch.setattr("crosscheck.studies.batches.run.perform_tasks", accepted)
    seed, refused = fresh_seed(), 0
    generator = random.Random(seed)
    for number in range(DRAWS):
        folder = tmp_path / str(number)
        folder.mkdir()
        given = draw(command, folder, generator)
        for path, text in given.files.items():
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(text if isinstance(text, bytes) else text.encode())
        before = files(folder)
        monkeypatch.chdir(folder)
        capfd.readouterr()
        code = left(given, monkeypatch)
        out, err = capfd.readouterr()
        about = f"seed {seed}, draw {number}: {given.arguments}\n{out}\n{err}"
        assert code in (0, 2, None), about
        if code == 2:
            refused += 1
            assert (out, err.count("\n"), err[-1:]) == ("", 1, "\n"), about
            assert err.startswith("crosscheck: "), about
            assert err[:-1].isprintable(), about
            assert len(err) - 1 <= LONGEST_LINE, about
            assert files(folder) == before, about
    print(f"{command}: seed {seed}, {DRAWS} command lines, {refused} refused")
    assert refused
