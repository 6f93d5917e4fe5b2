"""Where numba keeps what it compiled, and that it follows the code.

numba compiles a function anew when the file that it stands in changes, but not when a function
that it calls does, in another file. It keeps the result beside the source, and refuses to work
where it cannot keep it anywhere.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

from crosscheck.models.places import own_folder, usable

PACKAGES = ("models", "audit")  # that have functions for numba; none calls one of another
VARIABLE = "NUMBA_CACHE_DIR"


def settle(root: Path) -> None:
    """Give numba a cache folder if it has none, and drop what is outdated; before any kernel."""
    folders = _source_folders(root, *PACKAGES)
    chosen = os.environ.get(VARIABLE)
    beside = [folder / "__pycache__" for folder in folders]
    if not (chosen and usable(Path(chosen))) and not all(map(usable, beside)):
        with suppress(OSError):  # no folder anywhere: numba says so
            os.environ[VARIABLE] = folder = str(own_folder() / "compiled")
            if "numba" in sys.modules:  # it reads the environment once
                sys.modules["numba"].config.CACHE_DIR = folder
    drop_outdated(root)


def drop_outdated(root: Path) -> None:
    """Remove what was compiled before the last change of any source file of its package."""
    for package in PACKAGES:
        folders = _source_folders(root, package)
        sources = (path for folder in folders for path in folder.glob("*.py"))
        changed = max((path.stat().st_mtime_ns for path in sources), default=0)
        for kept in _compiled(folders):
            with suppress(OSError):  # another process was faster, or the folder is not ours
                if kept.stat().st_mtime_ns < changed:
                    kept.unlink()


def compiled_files(root: Path) -> list[Path]:
    """All files of compiled code that numba keeps of the packages under ``root``, sorted."""
    return sorted(_compiled(_source_folders(root, *PACKAGES)))


def _source_folders(root: Path, *packages: str) -> set[Path]:
    return {path.parent for package in packages for path in (root / package).rglob("*.py")}


def _compiled(folders: Iterable[Path]) -> Iterator[Path]:
    """Files of these folders' compiled functions, beside them or where numba was told to."""
    chosen = os.environ.get(VARIABLE)
    for folder in folders:
        yield from (folder / "__pycache__").glob("*.nb[ci]")
        if chosen:
            # numba's own name for a folder of sources
            name = f"{folder.name}_{hashlib.sha1(str(folder).encode()).hexdigest()}"
            yield from (Path(chosen) / name).glob("*.nb[ci]")
