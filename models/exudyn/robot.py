"""A robot in Exudyn: its kinematic tree of the robot's data, rotors among the links.

Exudyn's joints turn about or slide along z; so each link's frame is turned until z is its axis.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.exudyn.engine import System, exudyn, items
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import BASE, Level, LinkFrame, Robot, Rotor

# Of its stator's mass, taken from it, at its centre of mass: Exudyn's bodies need one, and it
# changes nothing there.
ROTORS_SHARE = 0.01
TURNING, SLIDING = exudyn.JointType.RevoluteZ, exudyn.JointType.PrismaticZ


class RobotPart(NamedTuple):
    """A link of the tree, with its joint's place in the parent's turned frame."""

    joint: Any
    parent: int
    rotation: np.ndarray
    position: np.ndarray
    mass: float
    com: np.ndarray
    inertia: np.ndarray


class ExudynRobot(RobotModel):
    """Exudyn's ObjectKinematicTree in minimal coordinates."""

    name = "exudyn"

    def __init__(self, robot: Robot, level: Level) -> None:
        super().__init__(robot, level)
        self._turned = [_with_z_along(joint.axis) for joint in robot.joints]
        parts = [self._link(number) for number in range(len(robot.joints))]
        follows = np.zeros((len(parts), len(parts)))
        for number, joint in enumerate(robot.joints):
            if joint.mimic is None:
                follows[number, number] = 1.0
            else:
                follows[number, joint.mimic.joint] = joint.mimic.multiplier
        rows = follows[:, robot.coordinates]
        offsets = [0.0 if joint.mimic is None else joint.mimic.offset for joint in robot.joints]
        added = np.zeros(len(parts))
        for rotor in robot.rotors:
            if level == "coupled":
                parts.append(self._rotor(rotor, parts))
                rows = np.vstack([rows, rotor.ratio * rows[rotor.joint]])
            added[rotor.joint] += rotor.inertia * rotor.ratio**2
        self._rows = rows
        self._offsets = np.array([*offsets, *[0.0] * (len(parts) - len(offsets))])
        diagonal = added if level == "armature" else np.zeros(len(parts))
        size = len(parts)
        sensors = self._sensors()
        self._heavy = System(
            size, lambda node: _tree(node, parts, robot.gravity, diagonal), sensors
        )
        self._weightless = System(size, lambda node: _tree(node, parts, np.zeros(3), diagonal))

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """Exudyn's, of the free coordinates (states, n, n)."""
        found = []
        for at in q @ self._rows.T + self._offsets:
            self._weightless.put(at, 0 * at)
            found.append(self._rows.T @ self._weightless.mass_matrix() @ self._rows)
        return np.array(found)

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """What Exudyn's right-hand side is without weight (states, n)."""
        return self._held(self._weightless, q, v)

    def gravity(self, q: np.ndarray) -> np.ndarray:
        """What Exudyn's right-hand side is at rest (states, n)."""
        return self._held(self._heavy, q, np.zeros_like(q))

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """M a less the right-hand side (states, n)."""
        needed: np.ndarray = (self.mass_matrix(q) @ a[:, :, None])[:, :, 0]
        return needed + self._held(self._heavy, q, v)

    def forward_dynamics(self, q: np.ndarray, v: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """By solving with its M (states, n)."""
        left = torques - self._held(self._heavy, q, v)
        found: np.ndarray = np.linalg.solve(self.mass_matrix(q), left[:, :, None])[:, :, 0]
        return found

    def tip(self, q: np.ndarray) -> np.ndarray:
        """By Exudyn's sensor of a point of the tree (states, 3) [m]."""
        frame = self.robot.frames[self.robot.tip]
        if frame.body == BASE:
            return np.tile(frame.placement.position, (len(q), 1))
        found = []
        for at in q @ self._rows.T + self._offsets:
            self._heavy.put(at, 0 * at)
            found.append(self._heavy.system.GetSensorValues(0))
        return np.array(found)

    def _sensors(self) -> list[Any]:
        """One of the tip's position, unless the tip stands on the ground."""
        frame = self.robot.frames[self.robot.tip]
        if frame.body == BASE:
            return []
        sensor = items.SensorKinematicTree(
            objectNumber=0,
            linkNumber=frame.body,
            localPosition=self._within(frame)[1],
            outputVariableType=exudyn.OutputVariableType.Position,
            writeToFile=False,
        )
        return [sensor]

    def _held(self, system: System, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Torques against which nothing accelerates (states, n)."""
        found = []
        for at, rate in zip(q @ self._rows.T + self._offsets, v @ self._rows.T, strict=True):
            system.put(at, rate)
            found.append(-system.right_hand_side() @ self._rows)
        return np.array(found)

    def _link(self, number: int) -> RobotPart:
        joint, body, own = (
            self.robot.joints[number],
            self.robot.bodies[number],
            self._turned[number],
        )
        rotation, position = self._within(LinkFrame(joint.parent, joint.placement))
        return RobotPart(
            SLIDING if joint.kind == "prismatic" else TURNING,
            joint.parent,
            rotation @ own,
            position,
            body.mass,
            own.T @ body.com,
            own.T @ body.inertia @ own,
        )

    def _rotor(self, rotor: Rotor, parts: list[RobotPart]) -> RobotPart:
        """A rotor as a link; its stator among the parts gets lighter."""
        frame = self.robot.frames[rotor.stator]
        rotation, _ = self._within(frame)
        placed, mass, com = rotation @ _with_z_along(rotor.axis), 1.0, np.zeros(3)
        if frame.body != BASE:
            stator = parts[frame.body]
            mass = ROTORS_SHARE * self.robot.bodies[frame.body].mass
            com = stator.com
            parts[frame.body] = stator._replace(mass=stator.mass - mass)
        spinning = np.diag([0.0, 0.0, rotor.inertia])
        return RobotPart(TURNING, frame.body, placed, com, mass, np.zeros(3), spinning)

    def _within(self, frame: LinkFrame) -> tuple[np.ndarray, np.ndarray]:
        """Rotation and position of a frame in the turned frame of its body."""
        rotation, position = frame.placement.rotation, frame.placement.position
        if frame.body == BASE:
            return rotation, position
        back = self._turned[frame.body].T
        return back @ rotation, back @ position


def _with_z_along(axis: np.ndarray) -> np.ndarray:
    """A rotation (3, 3) whose third column is the axis."""
    other = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(other, axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def _tree(
    node: int, parts: list[RobotPart], gravity: np.ndarray, diagonal: np.ndarray
) -> list[Any]:
    """The tree, and an object that adds to the diagonal of its mass matrix."""
    matrices, vectors = exudyn.Matrix3DList, exudyn.Vector3DList
    tree = items.ObjectKinematicTree(
        nodeNumber=node,
        jointTypes=[part.joint for part in parts],
        linkParents=[part.parent for part in parts],
        jointTransformations=matrices([part.rotation for part in parts]),
        jointOffsets=vectors([part.position for part in parts]),
        linkInertiasCOM=matrices([part.inertia for part in parts]),
        linkCOMs=vectors([part.com for part in parts]),
        linkMasses=[part.mass for part in parts],
        gravity=list(gravity),
    )
    added = items.ObjectGenericODE2(nodeNumbers=[node], massMatrix=np.diag(diagonal))
    return [tree, added]
