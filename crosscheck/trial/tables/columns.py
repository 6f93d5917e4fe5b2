"""Names of the columns of states and of answers; those of answers are the same in every file."""

from __future__ import annotations

from crosscheck.models.arm.arm import Arm
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.input.calls import MATRICES
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.tables.asked import PARTS

ROW = "row"
# What a part is called in files.
SHORT = {part: part for part in PARTS} | {"mass_matrix": "M"}
# 1 in a row where a trial looks the part up, 0 where it may be left out.
NEEDED = tuple(f"for_{short}" for short in SHORT.values())
# What an argument is called in files, and the rest of its unit.
LETTERS = {"x": "q", "v": "v", "a": "a"}
PER_TIME = {"x": "", "v": "_per_s", "a": "_per_s2"}


def argument_columns(frame: Frame, coordinates: Coordinates, arm: Arm) -> dict[str, list[str]]:
    """Columns of every argument, units at their ends; of a matrix's coordinates, that have none,
    without."""
    units = _units(frame, coordinates)
    found = {"t": ["t_s"]}
    for argument, letter in LETTERS.items():
        found[argument] = [
            f"{letter}_{name}" + (f"_{unit}{PER_TIME[argument]}" if unit else "")
            for name, unit in zip(frame.names, units, strict=True)
        ]
    joints = range(1, len(arm.joints) + 1)
    return {**found, "torque": [f"torque_{joint}_N_m" for joint in joints]}


def _units(frame: Frame, coordinates: Coordinates) -> list[str]:
    if coordinates.matrix is not None:
        return [""] * len(frame.names)
    if coordinates.gears == "angles":
        return ["rad"] * len(frame.names)
    usual = {c.name: "rad" if c.is_angle else "m" for c in frame.layout.coordinates}
    ordered = coordinates.order or tuple(usual)
    return [usual.get(name, "rad") for name in ordered]


def answer_columns(part: str, n: int) -> list[str]:
    """Columns of a part's answers, row by row of a matrix."""
    if part in MATRICES:
        return [f"{SHORT[part]}_{i}_{j}" for i in range(1, n + 1) for j in range(1, n + 1)]
    return [f"{SHORT[part]}_{i}" for i in range(1, n + 1)]
