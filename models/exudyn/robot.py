"""A robot in Exudyn: its kinematic tree of the robot's data, rotors among the links.

Exudyn's joints turn about or slide along z; so each link's frame is turned until z is its axis.
A rotor that has a mesh turns against a shaft of its own, which turns as a rigid gear would turn it.
So do the sun of a stage and its planets, which are one body on the carrier: what they turn beyond
their shafts is what the teeth have come together.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.models.exudyn.engine import (
    NodeSystem,
    TreePart,
    UserFunction,
    build_tree,
    exudyn,
    items,
)
from crosscheck.models.exudyn.tree.wheels import base_radius, inertia
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import BASE, WITH_ROTORS, Level, LinkFrame, Robot, RotorMesh

if TYPE_CHECKING:
    from crosscheck.models.exudyn.elastic import ElasticStage

# Of its stator's mass, taken from it, at its centre of mass: Exudyn's bodies need one, and it
# changes nothing there.
ROTORS_SHARE = 0.01
# Of the lightest mass, in place of none: Exudyn divides by the mass of two bodies together.
GRAIN = 1e-18
SENSOR_VARIABLES = (
    exudyn.OutputVariableType.Position,
    exudyn.OutputVariableType.Velocity,
    exudyn.OutputVariableType.AngularVelocityLocal,
    exudyn.OutputVariableType.RotationMatrix,
)
TURNING, SLIDING = exudyn.JointType.RevoluteZ, exudyn.JointType.PrismaticZ


class ExudynRobot(RobotModel):
    """Exudyn's ObjectKinematicTree in minimal coordinates."""

    name = "exudyn"

    def __init__(self, robot: Robot, level: Level) -> None:
        super().__init__(robot, level)
        masses = [body.mass for body in robot.bodies]
        grain = GRAIN * min((mass for mass in masses if mass), default=1.0)
        self._masses = [mass or grain for mass in masses]
        self._axis_rotations = [_rotation_to_axis(joint.axis) for joint in robot.joints]
        parts = [self._link(number) for number in range(len(robot.joints))]
        free, meshes = robot.coordinates, robot.meshes if level == "geared" else ()
        springs = robot.mesh_coordinates if level == "geared" else 0
        factors, offsets = robot.joint_map
        rows = np.hstack([factors, np.zeros((len(parts), springs))])
        motors = [{joint: 1.0} for joint in free]  # of each torque, what it is in the tree
        added, rotor_meshes = np.zeros(len(parts)), list[tuple[int, RotorMesh]]()
        for rotor in robot.rotors:
            added[rotor.joint] += rotor.inertia * rotor.ratio**2
            if level not in WITH_ROTORS:
                continue
            frame = robot.frames[rotor.stator]
            placed = self._pose_in_body(frame)[0] @ _rotation_to_axis(rotor.axis)
            teeth = bool(meshes and rotor.mesh)
            parts += self._spinning_parts(frame.body, placed, rotor.inertia, parts, teeth)
            rows = np.vstack([rows, rotor.ratio * rows[rotor.joint]])
            if meshes and rotor.mesh:
                turns = np.zeros(rows.shape[1])
                turns[len(free) + len(rotor_meshes)] = 1 / rotor.mesh.pinion_base_radius_m
                rows = np.vstack([rows, turns])
                shaft, turned = len(rows) - 2, len(rows) - 1
                rotor_meshes.append((turned, rotor.mesh))
                if rotor.joint in free:
                    efforts = {shaft: 1 / rotor.ratio, turned: 1 / rotor.ratio}
                    motors[free.index(rotor.joint)] = efforts
        elastic_stages: list[ElasticStage] = []
        for stage, columns in zip(robot.stages, robot.stage_columns, strict=True):
            gears, moved = stage.gears, stage.joint
            wheels = gears.sun_teeth, gears.planet_teeth, gears.ring_teeth
            r_s, r_p, r_r = (base_radius(gears, each) for each in wheels)
            sun_turns, planet_turns = 1 + r_r / r_s, -r_r / r_p  # the planet's on the carrier
            J_s, J_p = inertia(gears, "sun"), gears.planet_count * inertia(gears, "planet")
            added[moved] += J_s * sun_turns**2 + J_p * (1 + planet_turns) ** 2
            if level not in WITH_ROTORS:
                continue
            is_elastic, place = level == "geared", len(parts)
            under = robot.joints[moved].parent
            parts += self._spinning_parts(under, parts[moved].rotation, J_s, parts, is_elastic)
            sun, planet = sun_turns * rows[moved], planet_turns * rows[moved]
            if not is_elastic:
                parts += self._spinning_parts(moved, np.eye(3), J_p, parts, False)
                rows = np.vstack([rows, sun, planet])
                continue
            # Compiled laws take half a second to import, and most robots have no stage.
            from crosscheck.models.exudyn.elastic import build_elastic_stage

            each, planet_rows = gears.planet_count // len(stage.groups), list[np.ndarray]()
            for number in stage.groups:
                parts += self._spinning_parts(
                    moved, np.eye(3), J_p / len(stage.groups), parts, True
                )
                places = moved, place + 1, place + 3 + 2 * number
                elastic_stages.append(build_elastic_stage(gears, number, *places, each))
                x_sp, x_pr = np.zeros((2, rows.shape[1]))
                x_sp[columns] = stage.displacement("x_sp", number)
                x_pr[columns] = stage.displacement("x_pr", number)
                planet_rows += [planet, -x_pr / r_p]
            rows = np.vstack([rows, sun, (x_sp + x_pr) / r_s, *planet_rows])
            if moved in free:
                motors[free.index(moved)] = {place: 1 / sun_turns, place + 1: 1 / sun_turns}
        self._rows, self._elastic_stages = rows, elastic_stages
        self._motors = np.array(
            [[efforts.get(n, 0.0) for n in range(len(parts))] for efforts in motors]
        )
        self._offsets = np.array([*offsets, *[0.0] * (len(parts) - len(offsets))])
        diagonal = np.zeros(len(parts))
        if level != "links":
            diagonal[: len(added)] = [joint.armature for joint in robot.joints]
        if level == "armature":
            diagonal[: len(added)] += added
        size = len(parts)
        self._parts = parts
        sensors = self._sensors()
        self._heavy = NodeSystem(
            size, lambda node: _tree(node, parts, robot.gravity, diagonal), sensors
        )
        self._weightless = NodeSystem(size, lambda node: _tree(node, parts, np.zeros(3), diagonal))
        self._elastic = NodeSystem(
            size,
            lambda node: _tree(
                node,
                parts,
                robot.gravity,
                diagonal,
                _mesh_torque_function(rotor_meshes, elastic_stages),
                [joint.friction for joint in robot.joints],
            ),
        )

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """Mass matrix over the free coordinates (states, n, n), from Exudyn's."""
        matrices = []
        for at in q @ self._rows.T + self._offsets:
            self._weightless.put(at, 0 * at)
            matrices.append(self._rows.T @ self._weightless.mass_matrix() @ self._rows)
        return np.array(matrices)

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal torques (states, n), by Exudyn's right-hand side weightless."""
        return self._holding_forces(self._weightless, q, v)

    def gravity(self, q: np.ndarray) -> np.ndarray:
        """Torques that hold the weights (states, n), from Exudyn's right-hand side at rest."""
        return self._holding_forces(self._heavy, q, np.zeros_like(q))

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Generalized forces of a motion (states, n): M a less Exudyn's right-hand side."""
        needed: np.ndarray = (self.mass_matrix(q) @ a[:, :, None])[:, :, 0]
        return needed + self._holding_forces(self._elastic, q, v)

    def forward_dynamics(self, q: np.ndarray, v: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """Accelerations under torques of motors (states, n), solved with Exudyn's M."""
        left = torques @ self._motors @ self._rows - self._holding_forces(self._elastic, q, v)
        return np.linalg.solve(self.mass_matrix(q), left[:, :, None])[:, :, 0]

    def stage_forces(self, q: np.ndarray) -> np.ndarray:
        """Forces (states, meshes) [N] of the springs of every planet, by angles of the tree."""
        forces = [
            [pull for stage in self._elastic_stages for pull in stage.spring_forces(angles)]
            for angles in (q @ self._rows.T + self._offsets).tolist()
        ]
        return np.array(forces)

    def energy(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Energy (states,) [J]: kinetic by Exudyn's M, the weights' by sensors of its bodies."""
        total: np.ndarray = np.einsum("si,sij,sj->s", v, self.mass_matrix(q), v) / 2
        weights = np.array([part.mass * self.robot.gravity for part in self._parts])
        places = np.array(list(self._sensor_values(q, v, kinds=1))).reshape(-1, *weights.shape)
        return total - (places * weights).sum(axis=(1, 2))

    def momentum(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Linear, then angular momentum (states, 6), by Exudyn's sensors of its bodies."""
        total = np.zeros((len(q), 6))
        for momentum, values in zip(total, self._sensor_values(q, v), strict=True):
            for part, (at, velocity, rate, rotation) in zip(self._parts, values, strict=True):
                momentum[:3] += part.mass * velocity
                momentum[3:] += part.mass * np.cross(at, velocity)
                momentum[3:] += rotation.reshape(3, 3) @ part.inertia @ rate
        return total

    def tip(self, q: np.ndarray) -> np.ndarray:
        """Position of the tip (states, 3) [m], by Exudyn's sensor of a point of the tree."""
        frame = self.robot.frames[self.robot.tip]
        if frame.body == BASE:
            return np.tile(frame.placement.position, (len(q), 1))
        positions = []
        for at in q @ self._rows.T + self._offsets:
            self._heavy.put(at, 0 * at)
            positions.append(
                self._heavy.system.GetSensorValues(len(self._parts) * len(SENSOR_VARIABLES))
            )
        return np.array(positions)

    def _sensors(self) -> list[Any]:
        """Sensors of every body, and one of the tip's place unless it stands on the ground."""
        frame = self.robot.frames[self.robot.tip]
        points = [
            (n, part.com, kind) for n, part in enumerate(self._parts) for kind in SENSOR_VARIABLES
        ]
        if frame.body != BASE:
            points.append((frame.body, self._pose_in_body(frame)[1], SENSOR_VARIABLES[0]))
        return [
            items.SensorKinematicTree(
                objectNumber=0,
                linkNumber=link,
                localPosition=at,
                outputVariableType=kind,
                writeToFile=False,
            )
            for link, at, kind in points
        ]

    def _sensor_values(self, q: np.ndarray, v: np.ndarray, kinds: int = 4) -> Iterator[list[Any]]:
        """For each state, what the first sensors of each body's centre of mass measure."""
        states = zip(q @ self._rows.T + self._offsets, v @ self._rows.T, strict=True)
        every = range(0, len(self._parts) * len(SENSOR_VARIABLES), len(SENSOR_VARIABLES))
        for at, rate in states:
            self._heavy.put(at, rate)
            measure = self._heavy.system.GetSensorValues
            yield [[np.array(measure(first + kind)) for kind in range(kinds)] for first in every]

    def _holding_forces(self, system: NodeSystem, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Generalized forces against which nothing in a system accelerates (states, n)."""
        forces = []
        for at, rate in zip(q @ self._rows.T + self._offsets, v @ self._rows.T, strict=True):
            system.put(at, rate)
            forces.append(-system.right_hand_side() @ self._rows)
        return np.array(forces)

    def _link(self, number: int) -> TreePart:
        joint, body, axis_rotation = (
            self.robot.joints[number],
            self.robot.bodies[number],
            self._axis_rotations[number],
        )
        rotation, position = self._pose_in_body(LinkFrame(joint.parent, joint.placement))
        return TreePart(
            SLIDING if joint.kind == "prismatic" else TURNING,
            joint.parent,
            rotation @ axis_rotation,
            position,
            self._masses[number],
            axis_rotation.T @ body.com,
            axis_rotation.T @ body.inertia @ axis_rotation,
        )

    def _spinning_parts(
        self,
        body: int,
        rotation: np.ndarray,
        inertia: float,
        parts: list[TreePart],
        has_shaft: bool,
    ) -> list[TreePart]:
        """Parts that let a link spin on a body: the link, before it the shaft that springs ask for.

        placed (3, 3): its frame in the body's turned one. That body gets lighter.
        """
        count, mass, com = 2 if has_shaft else 1, 1.0, np.zeros(3)
        if body != BASE:
            stator = parts[body]
            mass = ROTORS_SHARE * self._masses[body]
            com = stator.com
            parts[body] = stator._replace(mass=stator.mass - count * mass)
        spinning, at = np.diag([0.0, 0.0, inertia]), np.zeros(3)
        rotor = TreePart(TURNING, body, rotation, com, mass, at, spinning)
        if not has_shaft:
            return [rotor]
        shaft = rotor._replace(inertia=0 * spinning)
        return [shaft, rotor._replace(parent=len(parts), rotation=np.eye(3), position=at)]

    def _pose_in_body(self, frame: LinkFrame) -> tuple[np.ndarray, np.ndarray]:
        """Rotation and position of a frame in the turned frame of its body."""
        rotation, position = frame.placement.rotation, frame.placement.position
        if frame.body == BASE:
            return rotation, position
        back = self._axis_rotations[frame.body].T
        return back @ rotation, back @ position


def _rotation_to_axis(axis: np.ndarray) -> np.ndarray:
    """A rotation (3, 3) whose third column is the axis."""
    other = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(other, axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def _mesh_torque_function(
    rotor_meshes: list[tuple[int, RotorMesh]], elastic_stages: list[ElasticStage]
) -> UserFunction:
    """User function with the meshes' torques on rotors, suns and planets against their shafts.

    And what the springs' potentials do to the joints whose angles they depend on. rotor_meshes:
    place of each rotor among the parts, and its mesh.
    """

    def torques(
        _system: object, _time: float, _item: int, angles: list[float], rates: list[float]
    ) -> list[float]:
        efforts = [0.0] * len(angles)
        for place, mesh in rotor_meshes:
            lever, play = mesh.pinion_base_radius_m, mesh.backlash_m
            ahead = lever * angles[place]
            pressed = max(ahead - play, 0.0) + min(ahead + play, 0.0)
            if pressed:
                damped = mesh.damping_N_s_per_m * lever * rates[place]
                efforts[place] = -lever * (mesh.stiffness_N_per_m * pressed + damped)
        for stage in elastic_stages:
            stage.add_efforts(efforts, angles, rates)
        return efforts

    return torques


def _tree(
    node: int,
    parts: list[TreePart],
    gravity: np.ndarray,
    diagonal: np.ndarray,
    teeth: UserFunction | None = None,
    friction: Sequence[float] = (),
) -> list[Any]:
    """The tree, and an object that adds to the diagonal of its mass matrix and pushes rotors.

    friction: of the first joints [N m s/rad], [N s/m], which the tree's own control at rest is.
    """
    added = items.ObjectGenericODE2(
        nodeNumbers=[node], massMatrix=np.diag(diagonal), forceUserFunction=teeth or 0
    )
    damping = [*friction, *[0.0] * (len(parts) - len(friction))] if any(friction) else []
    return [build_tree(node, parts, gravity.tolist(), damping=damping), added]
