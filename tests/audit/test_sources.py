"""What a kept result depends on: each file that it runs, and no view."""

import json
import sys
from pathlib import Path, PurePath

import pytest

from crosscheck.provenance import ROOT
from crosscheck.runner import sources
from crosscheck.runner.sources import compute_code_hash
from tests.audit import traced_results
from tests.loops import require_items
from tests.processes import command_line

SCRIPT = Path(traced_results.__file__)
# What only says or draws what others have computed: folders, parts of names, files in audit.
ROOMS = ("crosscheck/report", "audit/templates", "audit/figures")
NAMES = ("chapter",)
FILES = ("report.py", "command.py", "sheet.py", "errata_texts.py")
Files = dict[str, dict[str, set[str]]]
EXUDYN = {f"models/exudyn/{name}.py" for name in ("tree/tree", "tree/mesh", "engine")}


@pytest.fixture(scope="module")
def files() -> Files:
    """Result -> files that its key is made of; files that ran or were read."""
    answer = command_line(python=(str(SCRIPT),), timeout=300)
    assert answer.returncode == 0, answer.stderr
    found = json.loads(answer.stdout)
    return {name: {kind: set(f) for kind, f in kinds.items()} for name, kinds in found.items()}


def is_view(path: PurePath) -> bool:
    """Of a file, its path from the project's folder."""
    folder = path.parent.as_posix()
    if path.suffix not in (".py", ".j2", ".css", ".js"):
        return False
    if any(folder == room or folder.startswith(f"{room}/") for room in ROOMS):
        return True
    if not folder.startswith("audit"):
        return False
    return path.name in FILES or any(name in path.stem for name in NAMES)


@pytest.mark.slow
def test_whatever_ran_counts(files):
    for result, looked in require_items(files.items()):
        assert len(looked["called"]) > 8, result  # the look was not in vain
        assert looked["called"] <= looked["counts"], result


def test_views_and_the_handling_of_processes_remake_nothing(files):
    for looked in require_items(files.values()):
        assert not [file for file in looked["counts"] if is_view(PurePath(file))]
        assert not [file for file in looked["counts"] if file.startswith("crosscheck/runner/")]


def test_every_engine_stands_for_itself(files):
    exudyn = {name for name, looked in files.items() if looked["counts"] >= EXUDYN}
    some_exudyn = {name for name, looked in files.items() if looked["counts"] & EXUDYN}
    assert exudyn == some_exudyn == {"exudyn run", "starts of exudyn"}
    # The measure runs the rigid arm, which nothing but a string names.
    assert "analytic/derivation/bodies.py" in files["starts of exudyn"]["counts"]
    assert "analytic/paper/printed.py" in files["printed run"]["counts"]
    assert "analytic/paper/printed.py" not in files["analytic run"]["counts"]


def test_arms_and_experiments_count_where_they_are_read_and_nowhere_else(files):
    pd, torque = (f"models/scenarios/{name}.toml" for name in ("pd", "constant-torque"))
    labelled = "models/arms/paper-labelled.toml"
    data = {
        name: {file for file in looked["counts"] if file.endswith(".toml")}
        for name, looked in files.items()
    }
    assert data["errata"] == {labelled, pd, torque}  # which it reads by itself
    assert data["exudyn run"] == {labelled, torque}


def own_measure() -> str:
    """Of this file, as a user's would be."""
    from crosscheck.audit.measures import events

    return events.side_change.__name__


def test_a_measure_from_outside_counts_with_all_that_it_imports():
    found = {path.relative_to(ROOT).as_posix() for path in sources.find_source_files(__name__)}
    assert {"tests/audit/test_sources.py", "audit/measures/events.py"} <= found
    assert "models/exudyn/tree/tree.py" not in found


IMPORTS = {
    "name": "from crosscheck.analytic.model import PhysicalModel",
    "module": "from crosscheck.analytic import model",
    "whole": "import crosscheck.analytic.model",
    "conditional": "if 1:\n from crosscheck.analytic import model",
    "inner": "def f():\n  def g():\n    import crosscheck.analytic.model as m",
}


@pytest.mark.parametrize("text", IMPORTS.values(), ids=IMPORTS)
def test_whatever_way_a_module_is_imported_it_counts(tmp_path, monkeypatch, text):
    (tmp_path / "user.py").write_text(text, encoding="utf-8")
    user = type(sys)("user")
    user.__file__ = str(tmp_path / "user.py")
    monkeypatch.setitem(sys.modules, "user", user)
    found = sources.find_source_files("user")
    assert ROOT / "analytic" / "model.py" in found
    assert ROOT / "models" / "exudyn" / "tree" / "tree.py" not in found


def test_a_guests_file_counts(tmp_path, monkeypatch):
    """Though it is not imported yet; what it imports from the project counts, too."""
    file = tmp_path / "guest_of_a_test.py"
    monkeypatch.syspath_prepend(tmp_path)
    hashes = set()
    for text in (
        "class Guest: pass",
        "class Guest: x = 1",
        "from crosscheck.models.experiment.drive import PD as Guest",
    ):
        file.write_text(text + "\n", encoding="utf-8")
        compute_code_hash.cache_clear()
        sources.find_imports.cache_clear()
        hashes.add(compute_code_hash("guest_of_a_test"))
    assert len(hashes) == 3
    assert "guest_of_a_test" not in sys.modules
