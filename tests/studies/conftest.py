"""The command line, for studies."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from crosscheck.cli.app import main
from crosscheck.studies.batches.run import How, run_study
from crosscheck.studies.definition.files import read_study
from tests.studies.studies import Hold, held_study

Command = Callable[..., tuple[int, str, str]]


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """``command(*arguments)``: exit code, output and errors."""

    def called(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["crosscheck", *map(str, arguments)])
        with pytest.raises(SystemExit) as left:
            main()
        out, err = capsys.readouterr()
        return int(left.value.code or 0), out, err

    return called


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A study's file, and its result, where nothing holds it."""
    folder = tmp_path_factory.mktemp("undisturbed")
    file, out = held_study(folder), folder / "out.nc"
    run_study(read_study(file, run_code=True), out, How())
    return file, out


@pytest.fixture
def hold(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int, int], Hold]:
    """``hold(batches, jobs)``."""

    def held(batches: int, jobs: int) -> Hold:
        return Hold(tmp_path_factory.mktemp("hold"), batches, jobs)

    return held
