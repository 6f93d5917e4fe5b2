"""Small studies, their files, and what is in a result, byte for byte."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from crosscheck.models.files import read_raw_arm, read_raw_scenario
from crosscheck.provenance import ROOT
from crosscheck.studies.definition.definition import Definition
from crosscheck.studies.definition.files import build_study
from crosscheck.studies.members.members import PreparedStudy
from tests.processes import wait_for

PEAK = {"kind": "peak", "signal": "theta_ddot"}
# Each call adds a byte to the file TALLY. Those beyond the first MOST wait until it is removed.
HELD = """\
import os
import time


def held(run):
    tally = os.environ.get("TALLY")
    if tally and os.path.exists(tally):
        with open(tally, "ab") as file:
            file.write(b".")
            file.flush()
            number = file.tell()
        while number > int(os.environ["MOST"]) and os.path.exists(tally):
            time.sleep(0.01)
    return {"last": run.theta[-1, 0]}
"""
BATCH, BATCHES = 32, 6
MEMBERS = BATCH * BATCHES
ARM = str(ROOT / "examples" / "robots" / "planetary-arm.toml")
ROBOT_STUDY = f"""
schema_version = 1
name = "robots"
robot = "{ARM}"
scenario = "pd"

[settings]
"scenario.duration_s" = 0.002
"scenario.start.mesh" = "centre"

[[axes]]
path = "robot.joints.elbow.*_mesh.backlash_m"
kind = "list"
values = [2e-5, 6e-5]

[[axes]]
path = "robot.links.fore.mass_kg"
kind = "list"
values = [18.9, 25.0]

[[quantities]]
kind = "final"
signal = "theta_dot"

[[quantities]]
kind = "peak"
signal = "F_sp"
joint = 2

[[quantities]]
kind = "peak"
signal = "F_pr"
joint = 2
"""
RIGHT = Path(__file__).with_name("right.toml")  # a study of samples and a list of payloads
HELD_STUDY = Path(__file__).with_name("held.toml").read_text(encoding="utf-8")


def study(
    axes: list[dict[str, Any]],
    quantities: list[dict[str, Any]] | None = None,
    arm: str = "paper-labelled",
    scenario: str = "pd",
    folder: Path = Path(),
    **more: Any,
) -> PreparedStudy:
    """Of these axes; 2 ms of the scenario unless settings say otherwise; folder: of functions."""
    settings = {"scenario.duration_s": 0.002, **more.pop("settings", {})}
    switches = more.pop("switches", {})
    given = {
        "schema_version": 1,
        "name": "study",
        "arm": arm,
        "scenario": scenario,
        "settings": settings,
        "axes": axes,
        "quantities": quantities or [PEAK],
        **more,
        "switches": switches,
    }
    definition = Definition.model_validate(given)
    data = {"arm": read_raw_arm(arm), "scenario": read_raw_scenario(scenario)}
    return build_study(definition, data, folder, "study.toml")


def held_study(folder: Path) -> Path:
    """Its file: six batches, which a `Hold` stops wherever a test wants."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "held.py").write_text(HELD, encoding="utf-8")
    file = folder / "held.toml"
    file.write_text(HELD_STUDY, encoding="utf-8")
    return file


class Hold:
    """Stops a study that runs with this environment once some of its batches are done.

    jobs: of the study's; with several, up to ``jobs - 1`` batches more than asked are done.
    """

    def __init__(self, folder: Path, batches: int, jobs: int) -> None:
        self.tally = folder / "tally"
        self.tally.touch()
        # The others' batches may lack their last member each.
        most = batches * BATCH + (jobs - 1) * (BATCH - 1)
        self.environment = {"TALLY": str(self.tally), "MOST": str(most)}

    def release(self) -> None:
        """Whatever waits goes on, and nothing waits any more."""
        self.tally.unlink()


def sweeping(
    file: Path, out: Path, *more: object, hold: Hold | None = None
) -> subprocess.Popen[str]:
    """`crosscheck sweep` in a group of processes of its own."""
    command = [sys.executable, "-m", "crosscheck", "sweep", file, "--out", out, "--run-code", *more]
    held = hold.environment if hold else {}
    return subprocess.Popen(
        list(map(str, command)),
        env={**os.environ, **held, "PYTHONPATH": str(ROOT)},
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )


def finished(program: subprocess.Popen[str]) -> tuple[int, str, str]:
    """Exit code, output and errors of a program, which is given two minutes."""
    out, err = program.communicate(timeout=120)
    return program.returncode, out, err


def batches_kept(out: Path) -> int:
    """How many batches are kept beside a result."""
    return len(list(out.with_name(f"{out.name}.batches").glob("*.kept")))


def wait_for_batches(out: Path, count: int, program: subprocess.Popen[str]) -> None:
    """Until so many are kept."""
    wait_for(lambda: batches_kept(out) >= count, program)


def kill(program: subprocess.Popen[str]) -> None:
    """The program and all its children, at once."""
    os.killpg(program.pid, signal.SIGKILL)
    program.communicate()


def content(path: Path) -> dict[str, tuple[bytes, dict[str, str]]]:
    """Every variable's bytes and attributes, and the file's own; not where and when it was made."""
    with h5py.File(path, "r") as file:
        found = {
            name: (_bytes(np.asarray(data[()])), _said(data))
            for name, data in file.items()
            if isinstance(data, h5py.Dataset)
        }
        found[""] = (b"", _said(file))
    return found


def _bytes(values: np.ndarray) -> bytes:
    return b"\n".join(values.tolist()) if values.dtype == object else values.tobytes()


def _said(node: h5py.HLObject) -> dict[str, str]:
    ours = {"provenance", "DIMENSION_LIST", "REFERENCE_LIST", "_Netcdf4Coordinates"}
    return {name: str(value) for name, value in node.attrs.items() if name not in ours}
