"""What numba keeps on disk is thrown away when any source file changes."""

import os
from pathlib import Path

import numba
import pytest
from numba.core.caching import _CacheLocator

from crosscheck.models.compiled import PACKAGES, VARIABLE, drop_outdated, settle
from crosscheck.models.places import own_folder

OTHER, OWN = PACKAGES


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A caller that was compiled at time 100, a callee in its package, and another package."""
    for name, time in {
        f"{OTHER}/other.py": 10,
        f"{OWN}/caller.py": 10,
        f"{OWN}/callee.py": 20,
        f"{OWN}/__pycache__/caller.f-1.py311.1.nbc": 100,
        f"{OWN}/__pycache__/caller.f-1.py311.nbi": 100,
        f"{OWN}/__pycache__/caller.cpython-311.pyc": 100,
    }.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
        os.utime(path, (time, time))
    return tmp_path


def kept(root: Path) -> set[str]:
    return {path.suffix for path in (root / OWN / "__pycache__").iterdir()}


def test_compiled_code_stays_while_no_source_changes(tree):
    drop_outdated(tree)
    assert kept(tree) == {".nbc", ".nbi", ".pyc"}


def test_a_change_of_what_it_calls_removes_it_and_none_in_another_package(tree):
    os.utime(tree / OTHER / "other.py", (200, 200))
    drop_outdated(tree)
    assert kept(tree) == {".nbc", ".nbi", ".pyc"}
    os.utime(tree / OWN / "callee.py", (200, 200))
    drop_outdated(tree)
    assert kept(tree) == {".pyc"}


def test_it_is_removed_where_numba_was_told_to_keep_it(tree, tmp_path, monkeypatch):
    chosen = tmp_path / "chosen"
    monkeypatch.setenv(VARIABLE, str(chosen))
    folder = chosen / _CacheLocator.get_suitable_cache_subpath(str(tree / OWN / "caller.py"))
    other = chosen / f"{OWN}_of_another_project"
    for kept_there in (folder, other):
        kept_there.mkdir(parents=True)
        (kept_there / "caller.nbi").touch()
        os.utime(kept_there / "caller.nbi", (100, 100))
    os.utime(tree / OWN / "callee.py", (200, 200))
    drop_outdated(tree)
    assert not list(folder.iterdir())
    assert list(other.iterdir())


def test_numba_is_told_nothing_where_it_can_keep_its_own(tree, monkeypatch):
    monkeypatch.delenv(VARIABLE, raising=False)
    settle(tree)
    assert VARIABLE not in os.environ


def test_a_chosen_folder_is_kept_if_it_can_be_used(tree, tmp_path, monkeypatch, request):
    request.addfinalizer(own_folder.cache_clear)
    monkeypatch.setattr(numba.config, "CACHE_DIR", numba.config.CACHE_DIR)  # to have it back
    (tree / OTHER / "__pycache__").touch()  # numba cannot keep anything in a file
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    for chosen, used in (
        (tmp_path / "mine", tmp_path / "mine"),
        ("/dev/null/mine", tmp_path / "geararm-crosscheck/compiled"),
    ):
        monkeypatch.setenv(VARIABLE, str(chosen))
        own_folder.cache_clear()
        settle(tree)
        assert os.environ[VARIABLE] == str(used)
