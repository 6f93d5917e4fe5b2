"""Robots for tests: URDFs put together from numbers, and random chains with rotors."""

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.arm.gears import PlanetaryStage
from crosscheck.models.robot.file import RobotFile, build_robot
from crosscheck.models.robot.robot import Robot
from crosscheck.registry import build_robot_model
from tests import arms

ENGINES = ("analytic", "pinocchio", "exudyn")


LIMIT = '<limit lower="-3" upper="3" velocity="0" effort="0"/>'


class Solid(NamedTuple):
    """Mass, centre of mass and the six inertias ixx, ixy, ixz, iyy, iyz, izz of a link."""

    mass: float = 1.0
    com: Sequence[float] = (0.0, 0.0, 0.0)
    inertia: Sequence[float] = (0.01, 0.0, 0.0, 0.01, 0.0, 0.01)
    rpy: Sequence[float] = (0.0, 0.0, 0.0)


def robot(text: str, joints: Mapping[str, Any] | None = None, **fields: Any) -> Robot:
    """Of a URDF's text and transmissions by joint."""
    data = {"schema_version": 1, "name": "tested", "urdf": "tested.urdf", "joints": joints or {}}
    file = RobotFile.model_validate(data | fields)
    return build_robot(file, text, "tested.toml", "tested.urdf")


def mass_matrices(own: Robot, q: Sequence[float]) -> list[np.ndarray]:
    """M of each engine at coordinates, of the links alone."""
    at = np.array([q])
    return [build_robot_model(name, own, "links").mass_matrix(at)[0] for name in ENGINES]


def _words(values: Sequence[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def urdf(*parts: str) -> str:
    """A URDF of these links and joints."""
    return f'<robot name="tested">{"".join(parts)}</robot>'


def link(name: str, solid: Solid | None = None) -> str:
    """A link; without mass if none is given."""
    if solid is None:
        return f'<link name="{name}"/>'
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    inertia = " ".join(
        f'{key}="{float(value)!r}"' for key, value in zip(keys, solid.inertia, strict=True)
    )
    return (
        f'<link name="{name}"><inertial><origin xyz="{_words(solid.com)}"'
        f' rpy="{_words(solid.rpy)}"/><mass value="{solid.mass!r}"/><inertia {inertia}/>'
        "</inertial></link>"
    )


def joint(
    name: str,
    parent: str,
    child: str,
    kind: str = "revolute",
    axis: Sequence[float] = (0.0, 0.0, 1.0),
    at: Sequence[float] = (0.0, 0.0, 0.0),
    rpy: Sequence[float] = (0.0, 0.0, 0.0),
    more: str = "",
) -> str:
    """A joint; more: elements inside it."""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{_words(at)}" rpy="{_words(rpy)}"/><axis xyz="{_words(axis)}"/>'
        f"{more or LIMIT}</joint>"
    )


MASS, LENGTH, INERTIA = 2.0, 0.6, 0.03
GEAR_FIELDS = {*PlanetaryStage.model_fields}
# A pendulum: a bob on an axis along y.
BOB = urdf(
    link("ground"),
    link("bob", Solid(MASS, (0, 0, -LENGTH), (0.02, 0, 0, INERTIA, 0, 0.01))),
    joint("swing", "ground", "bob", axis=(0, 1, 0)),
)


def geared(ratio: float, inertia: float = 1e-3, **more: Any) -> dict[str, Any]:
    """A transmission."""
    return {"kind": "geared", "ratio": ratio, "rotor_inertia_kg_m2": inertia, **more}


def planetary(**changes: Any) -> dict[str, Any]:
    """A transmission by a planetary stage, whose ratio is 4."""
    return {
        "kind": "planetary",
        "sun_teeth": 24,
        "planet_teeth": 24,
        "ring_teeth": 72,
        "module_m": 0.002,
        "pressure_angle_deg": 20.0,
        "sun_inertia_kg_m2": 3e-4,
        "planet_inertia_kg_m2": 1e-4,
        "sun_mesh": contact(),
        "ring_mesh": contact(backlash_m=2e-5, phase_rad=0.7),
        **changes,
    }


def contact(**changes: Any) -> dict[str, Any]:
    """A planet's mesh with sun or ring."""
    return {
        "stiffness": {"law": "sine", "mean_N_per_m": 1e7, "amplitude_N_per_m": 2e6},
        "backlash_m": 1e-5,
        "tooth_error_m": 3e-6,
        "tooth_error_phase_rad": 0.4,
        "static_error_m": 1e-6,
        "damping_N_s_per_m": 300.0,
        **changes,
    }


def teeth(
    radius: float = 0.01, stiffness: float = 1e6, damping: float = 0.0, play: float = 0.0
) -> dict[str, float]:
    """A mesh."""
    return {
        "pinion_base_radius_m": radius,
        "stiffness_N_per_m": stiffness,
        "damping_N_s_per_m": damping,
        "backlash_m": play,
    }


def stepped(
    slope: Callable[[float, np.ndarray, np.ndarray], np.ndarray],
    q: np.ndarray,
    v: np.ndarray,
    steps: int,
    seconds: float = 1.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and rates after equal steps of the classical Runge-Kutta method.

    slope: accelerations by the number of the stage, in steps, and the state.
    """
    h = seconds / steps
    for step in range(steps):
        a1 = slope(step, q, v)
        v2 = v + h / 2 * a1
        a2 = slope(step + 0.5, q + h / 2 * v, v2)
        v3 = v + h / 2 * a2
        a3 = slope(step + 0.5, q + h / 2 * v2, v3)
        v4 = v + h * a3
        a4 = slope(step + 1, q + h * v3, v4)
        q = q + h / 6 * (v + 2 * v2 + 2 * v3 + v4)
        v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return q, v


def random_chain(seed: int, most_joints: int = 7) -> Robot:
    """Joints of any kind and axis; fixed links, branches, mimics, rotors, stages, friction."""
    draw, meshed, staged = random.Random(seed), random.Random(-seed), random.Random(str(seed))
    rubbing, parted = random.Random(f"friction {seed}"), random.Random(f"planets {seed}")
    parts, names, leading = [link("ground", Solid(com=(0.1, 0.2, 0.3)))], ["ground"], []
    transmissions: dict[str, Any] = {}
    sliding: dict[str, bool] = {}
    for number in range(draw.randint(1, most_joints)):
        name, kind = f"j{number}", draw.choice(("revolute", "continuous", "prismatic"))
        sliding[name] = kind == "prismatic"
        parent = names[-1] if draw.random() < 0.8 else draw.choice(names)
        more = '<limit lower="-1" upper="2" velocity="1" effort="1"/>'
        if leading and draw.random() < 0.15:
            more += f'<mimic joint="{draw.choice(leading)}" multiplier="-0.7" offset="0.2"/>'
        else:
            leading.append(name)
        axis = draw.choice(([1, 0, 0], [0, 0, -1], _three(draw, 1), _three(draw, 1)))
        own = [_three(draw, 0.5), _three(draw, 3)]
        parts += [
            joint(name, parent, f"l{number}", kind, axis, *own, more),
            link(f"l{number}", _solid(draw)),
        ]
        names.append(f"l{number}")
        if draw.random() < 0.4:
            place = [_three(draw, 0.2), _three(draw, 3)]
            parts.append(joint(f"f{number}", names[-1], f"p{number}", "fixed", [1, 0, 0], *place))
            parts.append(link(f"p{number}", _solid(draw) if draw.random() < 0.7 else None))
            names.append(f"p{number}")
        if draw.random() < 0.7:
            transmissions[name] = geared(
                draw.choice((-1, 1)) * 10 ** draw.uniform(0, 2.3), 10 ** draw.uniform(-6, -3)
            )
    for name, own in transmissions.items():
        if draw.random() < 0.5:
            own |= {"stator": draw.choice(names), "rotor_axis": _three(draw, 1)}
        if meshed.random() < 0.6:
            damping, play = 10 ** meshed.uniform(0, 3), 10 ** meshed.uniform(-6, -4)
            own["mesh"] = teeth(
                10 ** meshed.uniform(-3, -1),
                10 ** meshed.uniform(4, 9),
                meshed.choice((0.0, damping)),
                meshed.choice((0.0, play)),
            )
        if not sliding[name] and staged.random() < 0.3:
            transmissions[name] = _random_stage(staged)
            if parted.random() < 0.5:
                transmissions[name]["planets"] = "free"
                arms.part_planets(_dice(parted), transmissions[name])
    for name in sliding:
        if rubbing.random() < 0.4:
            own = transmissions.setdefault(name, {"kind": "direct"})
            own["friction_N_m_s_per_rad"] = 10 ** rubbing.uniform(-2, 3)
    gravity = _three(draw, 10)
    return robot(urdf(*parts), transmissions, gravity_m_per_s2=gravity)


def _dice(draw: random.Random) -> arms.Dice:
    return arms.Dice(draw.uniform, draw.randint)


def _random_stage(draw: random.Random) -> dict[str, Any]:
    """Gears of any size that can be assembled, with any law of stiffness."""
    joint = arms.planetary_joint(_dice(draw))
    stage = joint.model_dump(include=GEAR_FIELDS, exclude_none=True)
    in_phase = stage["sun_teeth"] % stage["planet_count"] == 0
    for side in ("sun_mesh", "ring_mesh"):
        stage[side] |= {
            "tooth_error_phase_rad": draw.uniform(-3, 3),
            "static_error_m": draw.uniform(-1e-6, 1e-6),
            "phase_rad": "from-teeth" if in_phase else draw.uniform(-3, 3),
        }
    return stage


def _solid(draw: random.Random) -> Solid:
    """A body that there can be, of point masses."""
    mass = 10 ** draw.uniform(-1, 1)
    points = np.array([_three(draw, 0.2) for _ in range(5)])
    points -= points.mean(axis=0)
    spread = points.T @ points * mass / 5
    own = np.trace(spread) * np.eye(3) - spread
    return Solid(mass, _three(draw, 0.3), own[np.triu_indices(3)].tolist(), _three(draw, 3))


def _three(draw: random.Random, size: float) -> list[float]:
    return [draw.uniform(-size, size) for _ in range(3)]


def build_wrong_exudyn(name: str, own: Robot, level: str) -> Any:
    """The model of an engine; Exudyn's has a hundredth more gravity."""
    gravity = own.gravity * 1.01 if name == "exudyn" else own.gravity
    return build_robot_model(name, replace(own, gravity=gravity), level)
