"""Faults in the robot that one engine is given: each is seen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Literal

import numpy as np
import pytest

from crosscheck.models.robot.robot import Robot, Rotor
from tests.faults.robots import engines_agree
from tests.robots.chains import ENGINES

Change = Callable[[Robot], Robot]


def of(kind: Literal["bodies", "joints", "rotors"], number: int, change: Callable) -> Change:
    """A robot, one of its parts changed."""

    def changed(own: Robot) -> Robot:
        parts = list(getattr(own, kind))
        parts[number] = change(parts[number])
        return replace(own, **{kind: tuple(parts)})

    return changed


body, moved, spun = partial(of, "bodies"), partial(of, "joints"), partial(of, "rotors")


def meshed(field: str, factor: float) -> Change:
    """Of the last rotor."""

    def changed(rotor: Rotor) -> Rotor:
        assert rotor.mesh
        update = {field: factor * getattr(rotor.mesh, field)}
        return replace(rotor, mesh=rotor.mesh.model_copy(update=update))

    return spun(2, changed)


SWAPPED = [0, 2, 1]
IN_LINKS: dict[str, Change] = {
    "sign of a centre of mass": body(1, lambda b: replace(b, com=b.com * [1, -1, 1])),
    "Ixy and Ixz swapped": body(
        1,
        lambda b: replace(
            b,
            inertia=np.diag(np.diag(b.inertia))
            + (b.inertia - np.diag(np.diag(b.inertia)))[np.ix_(SWAPPED, SWAPPED)],
        ),
    ),
    "inertia about the joint": body(
        0,
        lambda b: replace(
            b, inertia=b.inertia + b.mass * (b.com @ b.com * np.eye(3) - np.outer(b.com, b.com))
        ),
    ),
    "mass a millionth off": body(3, lambda b: replace(b, mass=b.mass * (1 + 1e-6))),
    "axis turned about": moved(1, lambda j: replace(j, axis=-j.axis)),
    "axis of a slide": moved(2, lambda j: replace(j, axis=j.axis[[2, 1, 0]])),
    "placement transposed": moved(
        0, lambda j: replace(j, placement=replace(j.placement, rotation=j.placement.rotation.T))
    ),
    "the link before the fixed one": moved(3, lambda j: replace(j, parent=1)),
    "a slide that turns": moved(2, lambda j: replace(j, kind="revolute")),
}
IN_ROTORS: dict[str, Change] = {
    "sign of a ratio": spun(2, lambda r: replace(r, ratio=-r.ratio)),
    "axis of a rotor": spun(1, lambda r: replace(r, axis=r.axis[[1, 2, 0]])),
    "stator's link": spun(2, lambda r: replace(r, stator="a")),
    "stator on the ground": spun(1, lambda r: replace(r, stator="ground")),
    "frame of the stator": spun(1, lambda r: replace(r, stator="b")),
    "rotor of another joint": spun(2, lambda r: replace(r, joint=0)),
    "inertia of a rotor": spun(2, lambda r: replace(r, inertia=r.inertia * 1.0001)),
    "multiplier of a mimic": moved(
        3, lambda j: replace(j, mimic=j.mimic and replace(j.mimic, multiplier=0.5))
    ),
    "offset of a mimic": moved(
        3, lambda j: replace(j, mimic=j.mimic and replace(j.mimic, offset=-0.3))
    ),
    "radius of a pinion": meshed("pinion_base_radius_m", 1.0001),
    "stiffness of a mesh": meshed("stiffness_N_per_m", 1.0001),
    "damping of a mesh": meshed("damping_N_s_per_m", 1.0001),
    "play of a mesh": meshed("backlash_m", 1.0001),
    "gravity upside down": lambda own: replace(own, gravity=-own.gravity),
}


@pytest.mark.parametrize("fault", IN_LINKS)
@pytest.mark.parametrize("engine", ["analytic", "exudyn"])  # Pinocchio reads the URDF itself
def test_wrong_links_are_seen(engine, fault):
    assert engines_agree("unlike", engine, IN_LINKS[fault]) == "differ"


@pytest.mark.parametrize("fault", IN_ROTORS)
@pytest.mark.parametrize("engine", ENGINES)
def test_wrong_rotors_are_seen(engine, fault):
    assert engines_agree("unlike", engine, IN_ROTORS[fault]) == "differ"


@pytest.mark.parametrize("engine", ENGINES)
def test_without_a_fault_nothing_differs(engine):
    assert engines_agree("unlike", engine) == "agree"
