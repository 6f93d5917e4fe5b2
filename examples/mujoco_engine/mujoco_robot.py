"""MuJoCo as one more engine of `crosscheck cost`: it reads the robot's URDF itself.

Its armature is a diagonal, so it has the levels links and armature. Two things of its reader are
put right. It loses the turn of an inertia's own frame (google-deepmind/mujoco, issue 3559), and it
finds principal axes by iteration, to some 1e-7 only: both come from the tensor that it has read.
"""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np

from crosscheck.models.arm.gears import PlanetaryStage
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import BASE, Level, Robot
from crosscheck.registry import ROBOT_ABILITIES, Entry

PARTS = ("visual", "collision", "dynamics")  # files of meshes, contacts and friction


class MujocoRobot(RobotModel):
    """M, bias, weight, accelerations by MuJoCo; joints that mimic follow by a constant matrix."""

    name = "mujoco"

    def __init__(self, robot: Robot, level: Level) -> None:
        super().__init__(robot, level)
        self._model = _compiled(robot)
        self._data = mujoco.MjData(self._model)
        self._given = np.zeros((self._model.nv, len(robot.coordinates)))
        self._offset = np.zeros(self._model.nv)
        places = [self._model.joint(joint.name).dofadr[0] for joint in robot.joints]
        for column, number in enumerate(robot.coordinates):
            self._given[places[number], column] = 1.0
        for place, joint in zip(places, robot.joints, strict=True):
            self._model.dof_damping[place] = joint.friction
            if joint.mimic:
                self._given[place] = joint.mimic.multiplier * self._given[places[joint.mimic.joint]]
                self._offset[place] = joint.mimic.offset
        for rotor in robot.rotors if level == "armature" else ():
            self._model.dof_armature[places[rotor.joint]] += rotor.inertia * rotor.ratio**2
        for stage in robot.stages if level == "armature" else ():
            self._model.dof_armature[places[stage.joint]] += _reflected(stage.gears)

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """By composite rigid bodies (states, n, n)."""
        found = np.zeros((len(q), self._model.nv, self._model.nv))
        for matrix, at in zip(found, q, strict=True):
            self._stand(at, 0 * at)
            mujoco.mj_fullM(self._model, matrix, self._data.qM)
        return self._given.T @ found @ self._given

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """By recursive Newton-Euler without weight (states, n)."""
        return self._held(q, v, np.zeros(3))

    def gravity(self, q: np.ndarray) -> np.ndarray:
        """By recursive Newton-Euler at rest (states, n)."""
        return self._held(q, 0 * q, self.robot.gravity)

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """By MuJoCo's own function for it (states, n)."""
        found = []
        self._model.opt.gravity = self.robot.gravity
        for at, rate, acceleration in zip(q, v, a, strict=True):
            self._stand(at, rate)
            self._data.qacc = self._given @ acceleration
            mujoco.mj_inverse(self._model, self._data)
            found.append(self._given.T @ self._data.qfrc_inverse)
        return np.array(found)

    def forward_dynamics(self, q: np.ndarray, v: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """By solving with its M (states, n)."""
        left = torques - self._held(q, v, self.robot.gravity) + self._rubbed(q, v)
        found: np.ndarray = np.linalg.solve(self.mass_matrix(q), left[:, :, None])[:, :, 0]
        return found

    def energy(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """MuJoCo's own (states,) [J]."""
        found = []
        self._model.opt.gravity = self.robot.gravity
        for at, rate in zip(q, v, strict=True):
            self._stand(at, rate)
            found.append(self._data.energy.sum())
        return np.array(found)

    def momentum(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """MuJoCo's own of the whole tree, whose centre it is about (states, 6)."""
        found = []
        for at, rate in zip(q, v, strict=True):
            self._stand(at, rate)
            mujoco.mj_subtreeVel(self._model, self._data)
            linear = self._data.subtree_linvel[0] * self._model.body_subtreemass[0]
            about = np.cross(self._data.subtree_com[0], linear)
            found.append(np.concatenate([linear, self._data.subtree_angmom[0] + about]))
        return np.array(found)

    def tip(self, q: np.ndarray) -> np.ndarray:
        """Of the body of that name (states, 3) [m]."""
        found = []
        for at in q:
            self._stand(at, 0 * at)
            found.append(self._data.body(self.robot.tip).xpos.copy())
        return np.array(found)

    def _stand(self, at: np.ndarray, rate: np.ndarray) -> None:
        self._data.qpos = self._given @ at + self._offset
        self._data.qvel = self._given @ rate
        mujoco.mj_forward(self._model, self._data)

    def _rubbed(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        found = []
        for at, rate in zip(q, v, strict=True):
            self._stand(at, rate)
            found.append(self._given.T @ self._data.qfrc_passive)
        return np.array(found)

    def _held(self, q: np.ndarray, v: np.ndarray, gravity: np.ndarray) -> np.ndarray:
        found = []
        self._model.opt.gravity = gravity
        for at, rate in zip(q, v, strict=True):
            self._stand(at, rate)
            found.append(self._given.T @ self._data.qfrc_bias)
        return np.array(found)


def _compiled(robot: Robot) -> Any:
    """A model of a URDF's joints and moving links alone, with inertias to the last digit."""
    root = ElementTree.fromstring(robot.urdf)
    turns = {}
    for element in root:
        frame = robot.frames.get(element.get("name")) if element.tag == "link" else None
        still = ("inertial",) if frame and frame.body == BASE else ()
        for part in [each for each in element if each.tag in (*PARTS, *still)]:
            element.remove(part)
        origin = element.find("inertial/origin")
        if origin is not None:
            turns[element.get("name")] = _turn(origin.get("rpy", "0 0 0"))
            origin.set("rpy", "0 0 0")
    spec = mujoco.MjSpec.from_string(ElementTree.tostring(root, encoding="unicode"))
    spec.compiler.fusestatic, spec.compiler.balanceinertia = False, True
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    read = {body.name: (body.mass, body.fullinertia.copy()) for body in spec.bodies}
    model = spec.compile()
    for name, turn in turns.items():
        number, (mass, (ixx, iyy, izz, ixy, ixz, iyz)) = model.body(name).id, read[name]
        own = turn @ np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]]) @ turn.T
        moments, axes = np.linalg.eigh(own)
        axes[:, 2] *= np.linalg.det(axes)
        model.body_mass[number], model.body_inertia[number] = mass, moments
        mujoco.mju_mat2Quat(model.body_iquat[number], axes.ravel())
        model.body_sameframe[number] = 0  # as compiled, perhaps parallel to the link; not any more
    return model


def _reflected(gears: PlanetaryStage) -> float:
    """Inertia [kg m^2] that a joint feels of the spins of its sun and planets."""
    pitch = gears.module_m / 2 * np.array([gears.sun_teeth, gears.planet_teeth])
    base = pitch * np.cos(np.radians(gears.pressure_angle_deg))
    given = gears.sun_inertia_kg_m2, gears.planet_inertia_kg_m2
    masses = gears.sun_equivalent_mass_kg, gears.planet_equivalent_mass_kg
    inertias = [
        mass * radius**2 if inertia is None else inertia
        for inertia, mass, radius in zip(given, masses, base, strict=True)
    ]
    sun, planet = pitch.sum() / pitch * (2, 1)  # turns, for one of the joint
    return float(inertias[0] * sun**2 + gears.planet_count * inertias[1] * planet**2)


def _turn(rpy: str) -> np.ndarray:
    quaternion, matrix = np.zeros(4), np.zeros(9)
    mujoco.mju_euler2Quat(quaternion, [float(angle) for angle in rpy.split()], "XYZ")
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


ENTRY = Entry(
    __name__,
    "MujocoRobot",
    "robot",
    ROBOT_ABILITIES,
    ("mujoco",),
    levels=("links", "armature"),
    title="MuJoCo's joints and armature",
)
