"""The frame of what a user says of the coordinates: names, a matrix, or a function."""

from __future__ import annotations

from collections import Counter
from typing import get_args

import numpy as np

from crosscheck.analytic.derivation.chain import Chain, build_exact_chain
from crosscheck.analytic.derivation.stage import Stage
from crosscheck.analytic.paper.kinematics import mesh_displacements
from crosscheck.models.arm import layout as layouts
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Coordinate, Layout
from crosscheck.models.errors import InputError
from crosscheck.trial.coordinates.curved import build_curved_frame
from crosscheck.trial.coordinates.frame import (
    WHERE,
    Frame,
    build_linear_frame,
    describe_coordinate_count,
    require_invertible,
    select_coordinate_names,
)
from crosscheck.trial.input.arrays import NotNumbers, convert_to_numbers
from crosscheck.trial.input.equations import Coordinates, Gearing

LAYOUTS = {
    "rigid": layouts.rigid_layout,
    "lumped": layouts.lumped_layout,
    "free": layouts.free_layout,
}


def build_frame(coordinates: Coordinates, arm: Arm) -> Frame:
    """The frame of a user's coordinates. Raises InputError."""
    _require_allowed_choices(coordinates)
    layout = LAYOUTS[coordinates.gearing](arm)
    if coordinates.function is not None:
        return build_curved_frame(coordinates, layout, arm)
    if coordinates.matrix is None:
        return _build_named_frame(coordinates, layout, arm)
    n = len(layout)
    try:
        matrix = convert_to_numbers(coordinates.matrix, (n, n))
    except NotNumbers as error:
        reason = f"{error}, for {describe_coordinate_count(coordinates, n, arm)}"
        raise InputError(WHERE, "matrix", None, reason) from None
    require_invertible(matrix, "matrix")
    names = select_coordinate_names(coordinates, [f"x_{k + 1}" for k in range(n)])
    return build_linear_frame(layout, names, matrix)


def _require_allowed_choices(coordinates: Coordinates) -> None:
    """Raise InputError for a word that is not allowed, or for two maps at once."""
    allowed = {
        "gearing": get_args(Gearing),
        "links": ("relative", "absolute"),
        "gears": ("displacements", "angles"),
    }
    for name, words in allowed.items():
        word = getattr(coordinates, name)
        if word not in words:
            raise InputError(WHERE, name, word, f"must be one of {', '.join(words)}")
    if coordinates.velocities is not None:
        raise InputError(WHERE, "velocities", None, "is for robots alone")
    if coordinates.matrix is not None and coordinates.function is not None:
        raise InputError(WHERE, "matrix", None, "give either matrix or function")
    map_field = "matrix" if coordinates.matrix is not None else "function"
    mapped = coordinates.matrix is not None or coordinates.function is not None
    usual = Coordinates()
    for name in ("links", "gears", "order"):
        if mapped and getattr(coordinates, name) != getattr(usual, name):
            reason = f"is for named coordinates; {map_field} alone says what x is"
            raise InputError(WHERE, name, getattr(coordinates, name), reason)
    for name in ("jacobian", "symbols"):
        if coordinates.function is None and getattr(coordinates, name) not in (None, ()):
            raise InputError(WHERE, name, None, "needs function beside")


def _build_named_frame(coordinates: Coordinates, layout: Layout, arm: Arm) -> Frame:
    """The frame of coordinates by name, in the user's order. Raises InputError."""
    usual = [_coordinate_name(coordinates, coordinate) for coordinate in layout.coordinates]
    ordered = coordinates.order or usual
    missing = [name for name in usual if name not in ordered]
    unknown = [name for name in ordered if name not in usual]
    twice = [name for name, count in Counter(ordered).items() if count > 1]
    mistakes = {"is without": missing, "has unknown": unknown, "has twice": twice}
    wrong = [f"{what} {', '.join(map(str, names))}" for what, names in mistakes.items() if names]
    if wrong:
        reason = f"{' and '.join(wrong)}; must be all of {', '.join(usual)}"
        raise InputError(WHERE, "order", None, reason)
    order = [usual.index(name) for name in ordered]
    numbers = _map_rows(build_exact_chain(arm, layout), coordinates)[:, order].astype(np.float64)
    names = select_coordinate_names(coordinates, [usual[place] for place in order])
    return build_linear_frame(layout, names, numbers)


def _coordinate_name(coordinates: Coordinates, meant: Coordinate) -> str:
    """The name of the coordinate of x that stands in place of one of the layout."""
    if meant.is_angle:
        return f"{'phi' if coordinates.links == 'absolute' else 'theta'}_{meant.joint}"
    if coordinates.gears == "displacements":
        return meant.name
    gear = f"theta_{'p' if meant.meaning == 'x_pr' else 's'}{meant.joint}"
    return gear + (f"_{meant.planet}" if meant.planet else "")


def _map_rows(chain: Chain, coordinates: Coordinates) -> np.ndarray:
    """Rows over x that give q, x in the layout's order."""
    layout_rows = [chain.row(c.meaning, c.joint, c.planet) for c in chain.layout.coordinates]
    turns = {joint: chain.row("theta", joint) for joint in chain.numbers}
    if coordinates.links == "absolute":
        turns |= {joint: turns[joint] - turns[joint - 1] for joint in chain.numbers if joint > 1}
    if coordinates.gears == "displacements":
        pairs = zip(chain.layout.coordinates, layout_rows, strict=True)
        return np.array([turns[c.joint] if c.is_angle else row for c, row in pairs])
    mapped_rows = []
    for meant in chain.layout.coordinates:
        turn, stage = turns[meant.joint], chain.stages[meant.joint - 1]
        if meant.is_angle:
            mapped_rows.append(turn)
            continue
        assert isinstance(stage, Stage)
        theta_s = chain.row("x_s" if chain.layout.free else "x_sp", meant.joint)
        theta_p = chain.row("x_pr", meant.joint, meant.planet)
        radii = stage.r_s, stage.r_p, stage.r_cp
        x_sp, x_pr = mesh_displacements(theta_s, theta_p, turn, *radii)  # Eqs. 2-3
        rows: dict[str, np.ndarray] = {"x_sp": x_sp, "x_pr": x_pr, "x_s": x_sp + x_pr}
        mapped_rows.append(rows[meant.meaning])
    return np.array(mapped_rows)
