"""The docs site's generated pages name all that the program has."""

from pathlib import Path

import pytest

from crosscheck.cli.app import build_commands
from crosscheck.models.experiment.scenario import Switches
from crosscheck.models.trajectory import VARIABLES
from crosscheck.registry import BUILT_IN
from tools.site import write_pages


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Text of each, by name."""
    folder: Path = tmp_path_factory.mktemp("site")
    write_pages(folder)
    return {path.stem: path.read_text(encoding="utf-8") for path in folder.iterdir()}


def test_commands_and_their_options(pages):
    names = [
        name for name, each in build_commands().commands.items() if not hasattr(each, "commands")
    ]
    assert [name for name in names if f"## crosscheck {name}\n" not in pages["commands"]] == []
    assert "## crosscheck baseline accept\n" in pages["commands"]
    assert "| `--rtol` |" in pages["commands"]


def test_models_switches_and_variables(pages):
    for names, page in (
        (BUILT_IN, "models"),
        (Switches.model_fields, "models"),
        (VARIABLES, "output-files"),
        (("findings[].tolerance", "answers.equations.models[].verdict"), "output-files"),
    ):
        assert [name for name in names if f"| `{name}` |" not in pages[page]] == []
