"""What numba keeps on disk is thrown away when any source file changes."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from models.compiled import drop_outdated


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A caller that was compiled at time 100 and a callee in another package."""
    for name, time in {
        "analytic/caller.py": 10,
        "models/callee.py": 20,
        "analytic/__pycache__/caller.f-1.py311.1.nbc": 100,
        "analytic/__pycache__/caller.f-1.py311.nbi": 100,
        "analytic/__pycache__/caller.cpython-311.pyc": 100,
    }.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
        os.utime(path, (time, time))
    return tmp_path


def kept(root: Path) -> set[str]:
    return {path.suffix for path in (root / "analytic/__pycache__").iterdir()}


def test_compiled_code_stays_while_no_source_changes(tree):
    drop_outdated(tree)
    assert kept(tree) == {".nbc", ".nbi", ".pyc"}


def test_a_change_in_another_package_removes_it(tree):
    os.utime(tree / "models/callee.py", (200, 200))
    drop_outdated(tree)
    assert kept(tree) == {".pyc"}
