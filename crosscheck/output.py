"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from models.errors import InputError


def require_writable(folder: Path) -> None:
    """Make the folder if need be. Raises InputError unless a file can be made in it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, prefix="."):
            pass
    except OSError as error:
        raise InputError(str(folder), "", None, f"cannot be written: {error.strerror}") from None


def write_text(path: Path, text: str) -> None:
    """Write a file through a temporary one beside it. Raises InputError."""
    require_writable(path.parent)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=".")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as stream:
            stream.write(text)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(str(path), "", None, f"cannot be written: {error.strerror}") from None
    finally:
        Path(temporary).unlink(missing_ok=True)
