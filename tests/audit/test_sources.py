"""What a kept result depends on: each file that it runs, and none that it does not."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

import pytest

from crosscheck.provenance import ROOT
from crosscheck.registry import BUILT_IN, home
from crosscheck.runner import sources
from crosscheck.runner.sources import code_hash, source_of, walked
from tests.audit import traced_results
from tests.processes import command_line

SCRIPT = Path(traced_results.__file__)
Files = dict[str, dict[str, set[str]]]
EXUDYN = {f"crosscheck/models/exudyn/{name}.py" for name in ("tree/tree", "tree/mesh", "engine")}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Files:
    """Result -> files whose edit changes its key; that ran or were read; that were imported."""
    copy = tmp_path_factory.mktemp("copy")
    without = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / sources.OWN, copy / sources.OWN, ignore=without)
    env = {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    answer = command_line(copy, python=(str(SCRIPT),), env=env, timeout=300)
    assert answer.returncode == 0, answer.stderr
    found = json.loads(answer.stdout)
    return {name: {kind: set(f) for kind, f in kinds.items()} for name, kinds in found.items()}


@pytest.mark.parametrize("result", traced_results.RESULTS)
def test_an_edit_of_what_ran_makes_the_result_anew(files, result):
    looked = files[result]
    assert len(looked["called"]) > 8  # the look was not in vain
    assert looked["called"] <= looked["edited"]


@pytest.mark.parametrize("result", traced_results.RESULTS)
def test_an_edit_of_what_was_not_even_imported_does_not(files, result):
    looked = files[result]
    code = {file for file in looked["edited"] if file.endswith(".py")}
    assert code <= looked["imported"]


def test_views_and_the_handling_of_processes_remake_nothing(files):
    for looked in files.values():
        for file in looked["edited"]:
            assert not file.startswith("crosscheck/report/"), file
            assert file.rpartition("/")[0] != "crosscheck" or file in (
                "crosscheck/__init__.py",
                "crosscheck/envelope.py",
                "crosscheck/registry.py",
                "crosscheck/signals.py",
            )


def test_every_engine_stands_for_itself(files):
    analytic = {
        name
        for name, looked in files.items()
        if "crosscheck/analytic/kernel/batch.py" in looked["edited"]
    }
    exudyn = {name for name, looked in files.items() if looked["edited"] >= EXUDYN}
    some_exudyn = {name for name, looked in files.items() if looked["edited"] & EXUDYN}
    assert exudyn == some_exudyn == {"exudyn run", "starts of exudyn"}
    assert analytic == set(files) - {"exudyn run", "pinocchio run", "floating base"}
    # The measure runs the rigid arm, which nothing but a string names.
    assert "crosscheck/analytic/derivation/rigid.py" in files["starts of exudyn"]["edited"]
    assert "crosscheck/analytic/paper/printed.py" in files["printed run, one planet"]["edited"]
    assert "crosscheck/analytic/paper/printed.py" not in files["analytic run"]["edited"]


def test_arms_and_experiments_count_where_they_are_read_and_nowhere_else(files):
    pd, torque = (f"crosscheck/models/scenarios/{name}.toml" for name in ("pd", "constant-torque"))
    labelled = "crosscheck/models/arms/paper-labelled.toml"
    data = {
        name: {file for file in looked["edited"] if file.endswith(".toml")}
        for name, looked in files.items()
    }
    swings = "crosscheck/models/scenarios/back-and-forth.toml"
    assert data["errata"] == {labelled, pd, torque, swings}  # which it reads by itself
    assert data["exudyn run"] == {labelled, torque}
    assert data["floating base"] == {labelled, pd}


def own_measure() -> str:
    """Of this file, as a user's would be."""
    from crosscheck.audit.measures import events

    return events.side_change.__name__


def test_a_measure_from_outside_counts_with_all_that_it_imports():
    found = {path.relative_to(ROOT).as_posix() for path in walked((__name__, "own_measure")).files}
    assert {"tests/audit/test_sources.py", "audit/measures/events.py"} <= found
    assert "models/exudyn/tree/tree.py" not in found


SOURCE = {
    "prefix": 'def f(level):\n    return build(f"analytic:{level}")',
    "constant": 'NAME = "analytic:physical"\ndef f():\n    return g(NAME)',
    "constant built": 'NAME = "analytic:physical"\ndef f():\n    return build(NAME)',
    "whatever": "def f(name):\n    return build(name)",
    "module": "def f():\n    return importlib.import_module('crosscheck.analytic.model')",
    "attribute": "from crosscheck.analytic import model\ndef f():\n    return model.PhysicalModel",
    "whole module": "import crosscheck.analytic.model\ndef f():\n    return g(analytic)",
    "renamed": "from crosscheck.analytic.model import PhysicalModel as P\nclass f(P):\n    pass",
    "default": "from crosscheck.analytic.model import FormModel\ndef f(kind=FormModel):\n    pass",
    "decorator": "from crosscheck.analytic import model\n@model.anything\ndef f():\n    pass",
    "conditional": "if 1:\n from crosscheck.analytic import model\ndef f():\n model.FormModel()",
    "inner": "def f():\n  def g():\n    import crosscheck.analytic.model as m\n    m.FormModel()",
    "on import": "from crosscheck.analytic import model\nmodel.prepare()\ndef f():\n    pass",
}


@pytest.mark.parametrize("text", SOURCE.values(), ids=SOURCE)
def test_whatever_way_a_model_is_named_it_counts(tmp_path, monkeypatch, text):
    head = "import importlib\nfrom crosscheck.registry import build\n"
    (tmp_path / "user.py").write_text(head + text, encoding="utf-8")
    user = type(sys)("user")
    user.__file__ = str(tmp_path / "user.py")
    monkeypatch.setitem(sys.modules, "user", user)
    found = walked(("user", "f")).files
    assert ROOT / "analytic" / "model.py" in found
    everything = ROOT / "models" / "exudyn" / "tree" / "tree.py" in found
    assert everything == (text == SOURCE["whatever"])


def test_another_meaning_of_a_name_is_another_key(tmp_path, monkeypatch):
    hashes = set()
    for meant in ("side_change", "teeth_return"):
        file = tmp_path / meant / "user.py"
        file.parent.mkdir()
        text = f"from crosscheck.audit.measures.events import {meant} as f\n"
        file.write_text(text, encoding="utf-8")
        user = type(sys)("user")
        user.__file__ = str(file)
        monkeypatch.setitem(sys.modules, "user", user)
        code_hash.cache_clear()
        hashes.add(code_hash(("user", "f")))
    assert len(hashes) == 2


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
        code_hash.cache_clear()
        source_of.cache_clear()
        hashes.add(code_hash(("guest_of_a_test", "Guest")))
    assert len(hashes) == 3
    assert "guest_of_a_test" not in sys.modules


def test_every_model_has_its_home():
    for name in BUILT_IN:
        module, kind = home(name)
        assert f"class {kind}(" in (ROOT / f"{module.replace('.', '/')}.py").read_text("utf-8")
