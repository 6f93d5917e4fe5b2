"""A short cross-check, its record, and the command line on it."""

import shutil
from pathlib import Path

import pytest

from crosscheck.baseline.file import baseline_path, write_baseline
from crosscheck.baseline.reduction import make_baseline
from crosscheck.cli import commands
from crosscheck.models.arm.arm import Arm
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.run import CrossCheck
from tests.baselines.short import quick, short_check
from tests.processes import Answer, Command


@pytest.fixture(scope="session")
def result(labelled: Arm) -> CrossCheck:
    """What is recorded here."""
    return short_check(labelled)


@pytest.fixture(scope="session")
def first_record(
    result: CrossCheck, labelled: Arm, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """A baseline file of it, which nobody changes."""
    path = baseline_path(tmp_path_factory.mktemp("recorded"), quick(labelled))
    write_baseline(path, make_baseline(result))
    return path


@pytest.fixture
def recorded(first_record: Path, tmp_path: Path) -> Path:
    """A baseline file of it, alone in a folder, where `command` looks for it."""
    folder = tmp_path / "baselines"
    folder.mkdir()
    return Path(shutil.copy(first_record, folder))


@pytest.fixture
def command(crosscheck: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Command:
    """``crosscheck ...`` in an empty folder; ``result=`` is what a cross-check comes to."""
    monkeypatch.chdir(tmp_path)

    def call(*words: object, result: CrossCheck | None = None) -> Answer:
        def cross_check(wanted: CrossCheckRequest, **options: object) -> CrossCheck:
            if result is None:
                pytest.fail("a cross-check was run")
            return result

        monkeypatch.setattr(commands, "run_cross_check", cross_check)
        return crosscheck(*words)

    return call
