"""Elements of an MJCF file that the robot does not use: a line for each kind, with names."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np


class NotedField(NamedTuple):
    """A field of a compiled model that is not used.

    kind: of the elements that have it; words: what it is; switch: a flag that disables it, which
    is named without the prefix that MuJoCo gives it.
    """

    name: str
    kind: str
    words: str
    switch: str = ""


# Fields that are 0 in a file without them, or -1 for mocap bodies.
FIELDS = (
    NotedField("body_mocapid", "body", "motion capture"),
    NotedField("body_plugin", "body", "plugin"),
    NotedField("jnt_stiffness", "joint", "stiffness", "SPRING"),
    NotedField("dof_frictionloss", "joint", "frictionloss", "FRICTIONLOSS"),
    NotedField("tendon_stiffness", "tendon", "stiffness", "SPRING"),
    NotedField("tendon_damping", "tendon", "damping", "DAMPER"),
    NotedField("tendon_armature", "tendon", "armature"),
    NotedField("tendon_frictionloss", "tendon", "frictionloss", "FRICTIONLOSS"),
    NotedField("tendon_limited", "tendon", "limit", "LIMIT"),
    NotedField("tendon_actfrclimited", "tendon", "limit of force"),
    NotedField("actuator_plugin", "actuator", "plugin"),
    NotedField("actuator_dyntype", "actuator", "activation"),
    NotedField("actuator_ctrllimited", "actuator", "limit of control"),
    NotedField("actuator_forcelimited", "actuator", "limit of force"),
    NotedField("actuator_actlimited", "actuator", "limit of activation"),
)
OPTIONS = {
    "density": "density of the fluid, {} kg/m^3,",
    "viscosity": "viscosity of the fluid, {} Pa s,",
    "wind": "wind, {} m/s,",
}


def list_notes(mujoco: Any, model: Any, touching: int) -> Iterator[str]:
    """A line for each kind of element of a compiled model that is not used.

    What the file itself switches off is not named. touching: how many geoms make contact.
    """
    for option, words in OPTIONS.items():
        values = np.ravel(getattr(model.opt, option))
        if values.any():
            yield f"{words.format(', '.join(f'{each:g}' for each in values))} is not used"
    shares = find_weight_shares(model)
    if len(set(shares.values())) > 1 and not is_disabled(mujoco, model, "GRAVITY"):
        names = [name for name, share in shares.items() if share != 1]
        yield f"gravcomp of body {', '.join(names)} is not used: the whole weight acts"
    for field in FIELDS:
        if not (field.switch and is_disabled(mujoco, model, field.switch)):
            names = list(_find_names(model, field))
            if names:
                yield f"{field.words} of {field.kind} {', '.join(names)} is not used"
    balls = [
        _name(model, "joint", number)
        for number in range(model.njnt)
        if model.jnt_type[number] == mujoco.mjtJoint.mjJNT_BALL and model.jnt_limited[number]
    ]
    if balls:
        yield f"range of ball {', '.join(balls)} is not used"
    yield from _list_actuators(mujoco, model)
    idle = [
        _name(model, "equality", number)
        for number in range(model.neq)
        if not is_active(mujoco, model, number)
    ]
    if idle:
        yield f"equality {', '.join(idle)} is not active"
    if touching and not is_disabled(mujoco, model, "CONTACT"):
        yield f"contacts of geoms ({touching}) are not used"


def count_touching_geoms(spec: Any) -> int:
    """The number of geoms of a file that may make contact, by themselves or in pairs."""
    names = {name for pair in spec.pairs for name in (pair.geomname1, pair.geomname2)}
    return sum(bool(geom.contype or geom.conaffinity or geom.name in names) for geom in spec.geoms)


def is_disabled(mujoco: Any, model: Any, flag: str) -> bool:
    """Whether a file disables something by a flag of its option."""
    return bool(model.opt.disableflags & getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}"))


def is_active(mujoco: Any, model: Any, equality: int) -> bool:
    """Whether an equality constrains joints."""
    off = any(is_disabled(mujoco, model, flag) for flag in ("CONSTRAINT", "EQUALITY"))
    return bool(model.eq_active0[equality]) and not off


def find_weight_shares(model: Any) -> dict[str, float]:
    """The share of its weight that acts on each body that moves and has a mass, by its name."""
    return {
        _name(model, "body", number): 1 - float(model.body_gravcomp[number])
        for number in range(model.nbody)
        if model.body_weldid[number] and model.body_mass[number]
    }


def _find_names(model: Any, field: NotedField) -> Iterator[str]:
    """Names of the elements that have a field which is not as it is by default."""
    default = -1 if field.name.endswith(("mocapid", "plugin")) else 0
    for number, value in enumerate(getattr(model, field.name)):
        if np.any(value != default):
            is_dof = field.name.startswith("dof_")
            yield _name(model, field.kind, int(model.dof_jntid[number]) if is_dof else number)


def _list_actuators(mujoco: Any, model: Any) -> Iterator[str]:
    """Lines on actuators that are more or less than a torque on a joint."""
    laws, others, kinds = [], [], mujoco.mjtTrn
    for number in range(model.nu):
        name = _name(model, "actuator", number)
        if model.actuator_trntype[number] not in (kinds.mjTRN_JOINT, kinds.mjTRN_JOINTINPARENT):
            others.append(name)
        unit = np.zeros(model.actuator_gainprm.shape[1])
        unit[0] = 1
        gain, bias = model.actuator_gaintype[number], model.actuator_biastype[number]
        is_torque = np.array_equal(model.actuator_gainprm[number], unit)
        is_torque &= not model.actuator_biasprm[number].any()
        if gain or bias or not is_torque:
            laws.append(name)
    if others:
        yield f"actuator {', '.join(others)} is not used: it acts on no joint"
    if laws:
        yield f"the law of actuator {', '.join(laws)} is not used: torques are given"


def _name(model: Any, kind: str, number: int) -> str:
    return getattr(model, kind)(number).name or f"{kind}_{number}"
