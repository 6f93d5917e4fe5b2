"""A robot in MuJoCo's format, MJCF, as a URDF, by MuJoCo's own importer.

The importer resolves defaults, included files, orientations, and inertias of shapes. What it has
compiled is written as links and joints, with armatures, and an element ``mjcf`` that holds what no
URDF has: gears of actuators, and notes on what is not used.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.robot.chains import UNLIMITED
from crosscheck.models.robot.mjcf.notes import (
    count_touching_geoms,
    find_weight_shares,
    is_active,
    is_disabled,
    list_notes,
)
from crosscheck.models.robot.robot import Placement
from crosscheck.models.robot.urdf import roll_pitch_yaw

ITERATED = 1e-5  # accuracy of an inertia: MuJoCo finds principal axes by iteration, to some 1e-6
# Python's message where MuJoCo runs out of memory, and for other failures.
NO_REASON = "Caught an unknown exception!"
FAILURE = "it fails without a reason, as of a shape that is too large for the memory"
MOST_BODIES = 10_000  # largest number of bodies of a model that is written as a URDF


class MjcfRobot(NamedTuple):
    """The result of reading an MJCF file: the text of a URDF, and gravity [m/s^2]."""

    urdf: str
    gravity: tuple[float, ...]


def convert_file(path: str, where: str) -> MjcfRobot:
    """The robot of an MJCF file; where: its name in messages. Raises InputError."""
    import mujoco

    try:
        spec = mujoco.MjSpec.from_file(path)
        if spec.flexes:
            allowed = "is deformable; bodies must be rigid"
            raise InputError(where, f"flex {spec.flexes[0].name}", None, allowed)
        touching = count_touching_geoms(spec)
        _remove_shapes(mujoco, spec)
        spec.njmax = spec.nconmax = -1  # room for contacts, of which there are none
        model = spec.compile()
    except (ValueError, TypeError, RuntimeError, mujoco.FatalError) as error:
        if isinstance(error, InputError):
            raise
        reason = " ".join(str(error).split()).replace(NO_REASON, FAILURE)
        raise InputError(where, "", None, f"MuJoCo cannot read it: {reason}") from None
    if model.nbody > MOST_BODIES:
        allowed = f"must be at most {MOST_BODIES:,}; there are {model.nbody:,}"
        raise InputError(where, "body", None, allowed)
    notes = list_notes(mujoco, model, touching)
    return MjcfRobot(_Writer(mujoco, spec, model, where).write(notes), _find_gravity(mujoco, model))


def _find_gravity(mujoco: Any, model: Any) -> tuple[float, ...]:
    """Gravity (3,) [m/s^2]: none if disabled, less where all bodies compensate it equally."""
    if is_disabled(mujoco, model, "GRAVITY"):
        return (0.0, 0.0, 0.0)
    shares = set(find_weight_shares(model).values())
    share = shares.pop() if len(shares) == 1 else 1.0
    return tuple(share * float(each) for each in model.opt.gravity)


def _remove_shapes(mujoco: Any, spec: Any) -> None:
    """Remove shapes of files where no inertia depends on them, so that the files may be missing."""
    kinds = mujoco.mjtGeom
    from_files = (kinds.mjGEOM_MESH, kinds.mjGEOM_HFIELD, kinds.mjGEOM_SDF)
    shapes = [geom for geom in spec.geoms if geom.type in from_files or geom.meshname]
    bodies = [geom.parent for geom in shapes]
    has_inertias = all(body.explicitinertial or body.name == "world" for body in bodies)
    by_shapes = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    if not has_inertias or spec.compiler.inertiafromgeom == by_shapes:
        return
    for each in (*spec.sensors, *spec.pairs, *spec.tuples, *spec.skins, *shapes):
        spec.delete(each)
    for each in spec.materials:
        each.textures = [""] * len(each.textures)
    for each in (*spec.meshes, *spec.hfields, *spec.textures):
        spec.delete(each)


class _Writer:
    """Writer of a compiled model as a URDF.

    A link is turned as its body, and its origin is the anchor of the body's joint.
    """

    def __init__(self, mujoco: Any, spec: Any, model: Any, where: str) -> None:
        self.mujoco, self.model, self.where = mujoco, model, where
        self.stated = {body.id: np.array(body.fullinertia) for body in spec.bodies}
        self.root = Element("robot", name=Path(where).stem)
        self.names = [self._name("body", number) for number in range(model.nbody)]
        self.anchors = [np.zeros(3)] * model.nbody  # of links, in the frames of their bodies

    def write(self, notes: Iterable[str]) -> str:
        """The text of the URDF, with notes. Raises InputError."""
        SubElement(self.root, "link", name=self.names[0])
        for number in range(1, self.model.nbody):
            self._write_body(number)
        self._write_followers()
        apart = SubElement(self.root, "mjcf")
        self._write_gears(apart)
        for note in notes:
            SubElement(apart, "note", text=note)
        return tostring(self.root, encoding="unicode")

    def _name(self, kind: str, number: int) -> str:
        return getattr(self.model, kind)(number).name or f"{kind}_{number}"

    def _write_body(self, number: int) -> None:
        """A body as a link, and its joints, with a link without mass between each and the next.

        Raises InputError.
        """
        model, name = self.model, self.names[number]
        parent = int(model.body_parentid[number])
        under, anchor = self.names[parent], self.anchors[parent]
        place = Placement(self._rotation(model.body_quat[number]), model.body_pos[number] - anchor)
        first, count = int(model.body_jntadr[number]), int(model.body_jntnum[number])
        for joint in range(first, first + count):
            is_last = joint == first + count - 1
            child = name if is_last else f"{name} after {self._name('joint', joint)}"
            link = SubElement(self.root, "link", name=child)
            ends = under, child
            element = self._add_joint(self._name("joint", joint), ends, place, joint)
            self._describe_joint(element, joint)
            self.anchors[number] = model.jnt_pos[joint]
            under, place = child, Placement(np.eye(3), -self.anchors[number])
        if not count:
            link = SubElement(self.root, "link", name=name)
            self._add_joint(f"to {name}", (under, name), place).set("type", "fixed")
        if model.body_mass[number]:
            self._write_inertia(link, number)

    def _place_at_zero(self, joint: int) -> Placement:
        """The placement of a joint's link in the body's frame at coordinate 0.

        As the file has it the coordinate is the joint's ref; a ball has none.
        """
        model, kinds = self.model, self.mujoco.mjtJoint
        axis, ref = model.jnt_axis[joint], model.qpos0[model.jnt_qposadr[joint]]
        if model.jnt_type[joint] == kinds.mjJNT_BALL:
            return Placement(np.eye(3), model.jnt_pos[joint])
        if model.jnt_type[joint] == kinds.mjJNT_SLIDE:
            return Placement(np.eye(3), model.jnt_pos[joint] - ref * axis)
        turn = np.zeros(4)
        self.mujoco.mju_axisAngle2Quat(turn, axis, -ref)
        return Placement(self._rotation(turn), model.jnt_pos[joint])

    def _add_joint(
        self, name: str, ends: tuple[str, str], outer: Placement, joint: int | None = None
    ) -> Element:
        """The joint between two links, the body of which is at ``outer`` in the first."""
        element = SubElement(self.root, "joint", name=name)
        SubElement(element, "parent", link=ends[0])
        SubElement(element, "child", link=ends[1])
        still = Placement(np.eye(3), np.zeros(3))
        inner = still if joint is None else self._place_at_zero(joint)
        if joint is not None and self.model.jnt_type[joint] == self.mujoco.mjtJoint.mjJNT_FREE:
            outer = inner = still  # its coordinates are those of the body in the world
        turn = outer.rotation @ inner.rotation
        place = outer.position + outer.rotation @ inner.position
        SubElement(element, "origin", xyz=_words(place), rpy=_words(roll_pitch_yaw(turn)))
        return element

    def _describe_joint(self, element: Element, joint: int) -> None:
        """Type, axis, limits and armature of a joint."""
        model, kinds = self.model, self.mujoco.mjtJoint
        kind = kinds(int(model.jnt_type[joint]))
        is_limited = bool(model.jnt_limited[joint])
        lower, upper = model.jnt_range[joint] if is_limited else (-UNLIMITED, UNLIMITED)
        if kind == kinds.mjJNT_SLIDE:
            element.set("type", "prismatic")
        elif kind == kinds.mjJNT_HINGE:
            element.set("type", "revolute" if is_limited else "continuous")
        else:
            element.set("type", "floating" if kind == kinds.mjJNT_FREE else "ball")
        SubElement(element, "axis", xyz=_words(model.jnt_axis[joint]))
        ends = {"lower": repr(float(lower)), "upper": repr(float(upper))}
        effort = np.abs(model.jnt_actfrcrange[joint]).max() * model.jnt_actfrclimited[joint]
        SubElement(element, "limit", {**ends, "velocity": "0", "effort": repr(float(effort))})
        row = model.jnt_dofadr[joint]
        numbers = {"armature": model.dof_armature[row]}
        if not is_disabled(self.mujoco, model, "DAMPER"):
            numbers["damping"] = model.dof_damping[row].max()
        SubElement(element, "dynamics", {key: repr(float(x)) for key, x in numbers.items()})

    def _write_inertia(self, link: Element, number: int) -> None:
        """Mass, centre and inertia of a body; the inertia that its file states, to all digits."""
        model = self.model
        turn = self._rotation(model.body_iquat[number])
        tensor = turn @ np.diag(model.body_inertia[number]) @ turn.T
        xx, yy, zz, xy, xz, yz = self.stated[number]
        stated = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if np.abs(stated - tensor).max() < ITERATED * np.abs(tensor).max():
            tensor = stated
        inertial = SubElement(link, "inertial")
        SubElement(inertial, "origin", xyz=_words(model.body_ipos[number] - self.anchors[number]))
        SubElement(inertial, "mass", value=repr(float(model.body_mass[number])))
        places = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2)}
        places |= {"iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
        SubElement(
            inertial, "inertia", {key: repr(float(tensor[at])) for key, at in places.items()}
        )

    def _write_followers(self) -> None:
        """Joints that follow another by an equality. Raises InputError for other equalities."""
        model = self.model
        joints = {each.get("name"): each for each in self.root.findall("joint")}
        active = (each for each in range(model.neq) if is_active(self.mujoco, model, each))
        for number in active:
            name, data = self._name("equality", number), model.eq_data[number]
            follower, leader = int(model.eq_obj1id[number]), int(model.eq_obj2id[number])
            is_of_joints = model.eq_type[number] == self.mujoco.mjtEq.mjEQ_JOINT
            if not is_of_joints or leader < 0 or data[2:5].any():
                allowed = "must make one joint follow another in proportion: only trees can be read"
                raise InputError(self.where, f"equality {name}", None, allowed)
            joint = joints[self._name("joint", follower)]
            if joint.find("mimic") is not None:
                allowed = "must be of a joint that no other equality has made follow one"
                raise InputError(self.where, f"equality {name}", None, allowed)
            own, other = (model.qpos0[model.jnt_qposadr[each]] for each in (follower, leader))
            SubElement(
                joint,
                "mimic",
                joint=self._name("joint", leader),
                multiplier=repr(float(data[1])),
                offset=repr(float(data[0] + own - data[1] * other)),
            )

    def _write_gears(self, under: Element) -> None:
        """The gear of each actuator of a joint; 1, which stands where none is stated, is none."""
        model, kinds = self.model, self.mujoco.mjtTrn
        of_joints = (kinds.mjTRN_JOINT, kinds.mjTRN_JOINTINPARENT)
        for number in range(model.nu):
            gear = float(model.actuator_gear[number, 0])
            if model.actuator_trntype[number] in of_joints and abs(gear) not in (0, 1):
                joint = self._name("joint", int(model.actuator_trnid[number, 0]))
                SubElement(
                    under,
                    "gear",
                    joint=joint,
                    value=repr(gear),
                    of=model.actuator(number).name or f"motor on {joint}",
                )

    def _rotation(self, quaternion: np.ndarray) -> np.ndarray:
        """Rotation (3, 3) of a quaternion."""
        turn = np.zeros(9)
        self.mujoco.mju_quat2Mat(turn, quaternion)
        return turn.reshape(3, 3)


def _words(numbers: np.ndarray) -> str:
    return " ".join(repr(float(number)) for number in numbers)
