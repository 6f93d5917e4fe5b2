"""Where a result comes from: versions, inputs, code, machine."""

from __future__ import annotations

import hashlib
import os
import platform
import subprocess
import sys
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any

from models.arm import Arm

ROOT = Path(__file__).parent.parent
PACKAGES = ("pin", "exudyn", "numpy", "scipy", "numba", "sympy", "xarray", "geararm-crosscheck")


def provenance(arm: Arm, seed: int, quick: bool) -> dict[str, Any]:
    """Everything that a reader needs to run the same again, JSON-able."""
    return {
        "command": _text(" ".join(["crosscheck", *sys.argv[1:]])),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "arm": arm.model_dump(mode="json"),
        "arm_sha256": hashlib.sha256(arm.model_dump_json().encode()).hexdigest(),
        "seed": seed,
        "quick": quick,
        "versions": {name: version(name) for name in PACKAGES},
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "revision": _revision(),
        "lock_sha256": _digest(ROOT / "run.lock"),
    }


def _text(argument: str) -> str:
    """Bytes that are no text in this locale, which files cannot hold, as escapes."""
    return argument.encode("utf-8", "backslashreplace").decode("utf-8")


def version(package: str) -> str | None:
    """Of an installed package; None if there is none."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _revision() -> str | None:
    """The git revision of this checkout, marked if the work tree differs; None outside one."""
    try:
        command = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--abbrev=12"]
        answer = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return answer.stdout.strip() or None


def _digest(path: Path) -> str | None:
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else None
