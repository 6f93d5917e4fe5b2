"""Studies that run undisturbed, or are held."""

from collections.abc import Callable
from pathlib import Path

import pytest

from crosscheck.studies.batches.run import ExecutionSettings, run_study
from crosscheck.studies.definition.files import read_study
from tests.processes import Answer, Command
from tests.studies.studies import Hold, held_study


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A study's file, and its result, where nothing holds it."""
    folder = tmp_path_factory.mktemp("undisturbed")
    file, out = held_study(folder), folder / "out.nc"
    run_study(read_study(file, run_code=True), out, ExecutionSettings())
    return file, out


@pytest.fixture
def hold(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int, int], Hold]:
    """``hold(batches, jobs)``."""

    def held(batches: int, jobs: int) -> Hold:
        return Hold(tmp_path_factory.mktemp("hold"), batches, jobs)

    return held


@pytest.fixture
def sweep(crosscheck: Command, tmp_path: Path) -> Command:
    """``sweep(file, *more)``: the command's answer; the result is tmp_path / "out.nc"."""

    def command(file: Path, *more: object) -> Answer:
        return crosscheck("sweep", file, "--out", tmp_path / "out.nc", *more)

    return command
