"""Checks, with the standard library alone, what the wheels cannot bring themselves."""

import ctypes
import platform
import sys
from pathlib import Path

MINIMUM = (3, 11)
# `import exudyn` loads its window library, which links against these two.
SYSTEM_LIBRARIES = {"libGL.so.1": "libgl1", "libX11.so.6": "libx11-6"}


def find_missing_libraries() -> list[str]:
    """Names of the Debian packages whose shared library cannot be loaded here."""
    missing = []
    for library, package in SYSTEM_LIBRARIES.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            missing.append(package)
    return missing


def find_problem() -> str | None:
    """One line on what stands in the way of the set-up, or None."""
    if not (Path(__file__).parents[1] / "crosscheck" / "models").is_dir():
        return (
            "crosscheck/models is no link to ../models: unpack or clone the project with its links"
        )
    if sys.version_info < MINIMUM:
        return f"Python {platform.python_version()} is too old: 3.11 or newer is needed"
    if sys.platform == "win32":
        return "Pinocchio has no Windows wheel: run this inside WSL2"
    if sys.platform.startswith("linux"):
        packages = find_missing_libraries()
        if packages:
            install = " ".join(packages)
            return f"Exudyn needs system libraries: apt-get update && apt-get install -y {install}"
    return None


if __name__ == "__main__":
    line = find_problem()
    if line is not None:
        sys.exit(f"preflight: {line}")
