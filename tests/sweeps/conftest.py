"""The command line, for studies."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from crosscheck.cli import main
from tests.sweeps.studies import finished, slow_study, sweeping

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


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A slow study's file, and its result in one process."""
    folder = tmp_path_factory.mktemp("undisturbed")
    file, out = slow_study(folder), folder / "out.nc"
    code, _, err = finished(sweeping(file, out, "--jobs", 1))
    assert code == 0, err
    return file, out
