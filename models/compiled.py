"""Compiled functions that numba keeps on disk must follow the code.

numba compiles a function anew when the file that it stands in changes, but not when a function
that it calls does, in another file.
"""

from __future__ import annotations

from pathlib import Path

PACKAGES = ("models", "analytic", "crosscheck")


def drop_outdated(root: Path) -> None:
    """Remove what was compiled before the last change of any source file of the packages."""
    folders = [root / package for package in PACKAGES]
    sources = [path for folder in folders for path in folder.rglob("*.py")]
    changed = max((path.stat().st_mtime_ns for path in sources), default=0)
    for folder in folders:
        for kept in folder.rglob("__pycache__/*.nb[ci]"):
            _remove_older(kept, changed)


def _remove_older(kept: Path, changed_ns: int) -> None:
    try:
        if kept.stat().st_mtime_ns < changed_ns:
            kept.unlink()
    except OSError:  # another process was faster, or the folder is not ours to change
        pass
