"""Where a result comes from: versions, inputs, code, machine."""

from __future__ import annotations

import hashlib
import os
import platform
import subprocess
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from crosscheck import LARGEST_SEED
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.quantities import Data
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.mechanism import Mechanism
from crosscheck.models.robot.file import RobotFile

ROOT = Path(__file__).parent.parent
RECORDS = "baselines"  # folder of records in a checkout, from which no result comes
PACKAGES = (
    *("pin", "exudyn", "numpy", "scipy", "llvmlite", "numba", "sympy", "xarray"),
    "geararm-crosscheck",
)


class Provenance(Data):
    """Everything that a reader needs to run the same again, of an arm or of a robot.

    arm_sha256: digest of the arm's values, or of the robot's file with its URDF; scenarios,
    switches: those that a user chose in place of the usual; model: name of the equations, of a
    trial. remarks: what was found out before anything ran.
    """

    command: str
    created: str
    arm: Arm | None = None
    robot: RobotFile | None = None
    arm_sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    seed: Annotated[int, Field(ge=0, le=LARGEST_SEED)]
    quick: bool
    scenarios: Annotated[tuple[Scenario, ...], Field(strict=False)] = ()
    switches: Switches | None = None
    model: str = ""
    remarks: Annotated[tuple[str, ...], Field(strict=False)] = ()
    versions: dict[str, str | None]
    python: str
    machine: str
    revision: str | None
    lock_sha256: str | None

    @property
    def content(self) -> Arm | RobotFile | None:
        """What the file of the arm or the robot holds; None where neither is named."""
        return self.arm or self.robot

    @property
    def name(self) -> str:
        """Name of the arm or the robot."""
        return self.content.name if self.content else ""


def record_provenance(
    mechanism: Mechanism,
    seed: int,
    quick: bool,
    scenarios: Sequence[Scenario] = (),
    chosen: Switches | None = None,
    remarks: Sequence[str] = (),
    packages: Sequence[str] = (),
    model: str = "",
) -> Provenance:
    """The Provenance of a result made now; packages: what it depends on beside the usual."""
    return Provenance(
        arm_sha256=mechanism_digest(mechanism),
        seed=seed,
        quick=quick,
        scenarios=tuple(scenarios),
        switches=chosen,
        model=model,
        remarks=tuple(remarks),
        **describe_surroundings(packages) | {mechanism.section: mechanism.content},
    )


def describe_surroundings(packages: Sequence[str] = ()) -> dict[str, Any]:
    """Command, time, versions, machine and code of a result made now, as Provenance has them."""
    # Bytes that are not text in this locale are written as escapes, since files cannot hold them.
    command = " ".join(["crosscheck", *sys.argv[1:]]).encode("utf-8", "backslashreplace")
    lock = ROOT / "run.lock"
    return {
        "command": command.decode("utf-8"),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "versions": {name: find_version(name) for name in (*PACKAGES, *packages)},
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "revision": _revision(),
        "lock_sha256": hashlib.sha256(lock.read_bytes()).hexdigest() if lock.is_file() else None,
    }


def mechanism_digest(mechanism: Mechanism) -> str:
    """SHA-256 of what an arm or a robot is."""
    return hashlib.sha256(mechanism.identity.encode()).hexdigest()


@cache
def find_version(package: str) -> str | None:
    """Version of an installed package; None if it is not installed."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


@cache
def _revision() -> str | None:
    """The git revision of this checkout, marked if the work tree differs; None outside one.

    As it stood when a process asked first: that is the code which it runs.
    """
    revision = _git("describe", "--always", "--abbrev=12")
    return f"{revision}-dirty" if revision and list_changed_files() else revision


def list_changed_files() -> list[str]:
    """The files of this checkout that differ from its revision; records come from it alone."""
    status = _git("status", "--porcelain", "--untracked-files=no", "--", ".", f":!{RECORDS}")
    return [line.split(maxsplit=1)[1] for line in (status or "").splitlines()]


def is_versioned(path: Path) -> bool:
    """Whether a file is one of this checkout, or would be: not of what git ignores."""
    place = path.resolve()
    inside = (ROOT / ".git").exists() and place.is_relative_to(ROOT.resolve())
    return inside and _git("check-ignore", str(place)) is None


def _git(*words: str) -> str | None:
    """Answer of git about this checkout; None outside one or if git finds nothing."""
    if not (ROOT / ".git").exists():  # another project's checkout may hold an installed package
        return None
    # GIT_DIR and its like, set in a hook of another repository, would name that one instead.
    environment = {name: value for name, value in os.environ.items() if name[:4] != "GIT_"}
    try:
        command = ["git", "--no-optional-locks", "-C", str(ROOT), *words]
        answer = subprocess.run(
            command, capture_output=True, text=True, timeout=10, check=True, env=environment
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return answer.stdout.strip() or None
