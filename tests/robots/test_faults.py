"""Faults in the robot that one engine is given: each is seen."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Literal

import numpy as np
import pytest

from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.stiffness import SineStiffness
from crosscheck.models.robot.robot import Robot, Rotor
from tests.faults.robots import engines_agree
from tests.robots.chains import ENGINES

Change = Callable[[Robot], Robot]


Kind = Literal["bodies", "joints", "rotors", "stages"]


def of(kind: Kind, number: int, change: Callable) -> Change:
    """A robot, one of its parts changed."""

    def changed(own: Robot) -> Robot:
        parts = list(getattr(own, kind))
        parts[number] = change(parts[number])
        return replace(own, **{kind: tuple(parts)})

    return changed


body, moved = partial(of, "bodies"), partial(of, "joints")
spun, staged = partial(of, "rotors"), partial(of, "stages")


def meshed(field: str, factor: float) -> Change:
    """Of the last rotor."""

    def changed(rotor: Rotor) -> Rotor:
        assert rotor.mesh
        update = {field: factor * getattr(rotor.mesh, field)}
        return replace(rotor, mesh=rotor.mesh.model_copy(update=update))

    return spun(2, changed)


def gears(**update: object) -> Change:
    """Of the second stage."""
    return staged(1, lambda stage: replace(stage, gears=stage.gears.model_copy(update=update)))


def toothed(side: str, **update: object) -> Change:
    """Of a mesh of the second stage."""

    def changed(own: Robot) -> Robot:
        mesh: Mesh = getattr(own.stages[1].gears, side)
        return gears(**{side: mesh.model_copy(update=update)})(own)

    return changed


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


IN_STAGES: dict[str, Change] = {
    "joint of a stage": lambda own: replace(
        own, stages=(own.stages[0], replace(own.stages[1], joint=2), own.stages[2])
    ),
    "teeth of the sun": gears(sun_teeth=27),
    "teeth of a planet": gears(planet_teeth=27),
    "teeth of the ring": gears(ring_teeth=81),
    "number of planets": gears(planet_count=3),
    "module": gears(module_m=0.0020002),
    "pressure angle": gears(pressure_angle_deg=20.01),
    "inertia of the sun": gears(sun_inertia_kg_m2=3.0003e-4),
    "inertia of a planet": gears(planet_inertia_kg_m2=1.0001e-4),
    "stiffness of a sun mesh": toothed(
        "sun_mesh", stiffness=SineStiffness(law="sine", mean_N_per_m=1e7, amplitude_N_per_m=1.9e6)
    ),
    "backlash of a ring mesh": toothed("ring_mesh", backlash_m=2.001e-5),
    "tooth error of a sun mesh": toothed("sun_mesh", tooth_error_m=3.001e-6),
    "its phase": toothed("ring_mesh", tooth_error_phase_rad=0.41),
    "standing error": toothed("ring_mesh", static_error_m=-1e-6),
    "phase of a ring mesh": toothed("ring_mesh", phase_rad=0.71),
    "damping of a ring mesh": toothed("ring_mesh", damping_N_s_per_m=300.1),
}


@pytest.mark.parametrize("fault", IN_LINKS)
@pytest.mark.parametrize("engine", ["analytic", "exudyn"])  # Pinocchio reads the URDF itself
def test_wrong_links_are_seen(engine, fault):
    assert engines_agree("unlike", engine, IN_LINKS[fault]) == "differ"


@pytest.mark.parametrize("fault", IN_ROTORS)
@pytest.mark.parametrize("engine", ENGINES)
def test_wrong_rotors_are_seen(engine, fault):
    assert engines_agree("unlike", engine, IN_ROTORS[fault]) == "differ"


@pytest.mark.parametrize("fault", IN_STAGES)
@pytest.mark.parametrize("engine", ENGINES)
def test_wrong_stages_are_seen(engine, fault):
    assert engines_agree("staged", engine, IN_STAGES[fault]) == "differ"


@pytest.mark.parametrize("name", ["unlike", "staged"])
@pytest.mark.parametrize("engine", ENGINES)
def test_without_a_fault_nothing_differs(engine, name):
    assert engines_agree(name, engine) == "agree"
