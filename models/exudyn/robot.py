"""A robot in Exudyn: its kinematic tree of the robot's data, rotors among the links.

Exudyn's joints turn about or slide along z; so each link's frame is turned until z is its axis.
Rotors, suns and all planets of a stage are balanced bodies, so nothing but teeth depends on their
angles. Those of a state are only what they turn beyond rigid gears, by which teeth come together:
added to what rigid gears turn, it would lose digits. Rates are whole.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from crosscheck.models.experiment.scenario import Switches
from crosscheck.models.exudyn.engine import Engine, TreePart, UserFunction, exudyn, items
from crosscheck.models.exudyn.tree.wheels import base_radius, inertia
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import (
    BASE,
    MESH_LAWS,
    WITH_ROTORS,
    JointStage,
    Level,
    LinkFrame,
    Robot,
    Rotor,
    RotorMesh,
)

if TYPE_CHECKING:
    from crosscheck.models.arm.gears import PlanetaryStage
    from crosscheck.models.exudyn.tree.mesh import TreeMesh

# [kg] For what has no mass, as rotors, whose masses the links have: the engine divides by a body's.
# No sum with a number of a robot notices so little.
NO_MASS = 1e-200
SENSOR_VARIABLES = (
    exudyn.OutputVariableType.Position,
    exudyn.OutputVariableType.Velocity,
    exudyn.OutputVariableType.AngularVelocityLocal,
    exudyn.OutputVariableType.RotationMatrix,
)
TURNING, SLIDING = exudyn.JointType.RevoluteZ, exudyn.JointType.PrismaticZ


class MeshPlaces(NamedTuple):
    """Places in the tree of a rotor that has a mesh and of its joint, whose ratio it turns."""

    rotor: int
    joint: int
    ratio: float
    mesh: RotorMesh


class ExudynRobot(RobotModel):
    """Exudyn's ObjectKinematicTree in minimal coordinates.

    parts: bodies of the tree, first those of the joints. rows (parts, n): rates of the tree by
    those of the coordinates. motors: by the free joints' numbers, the part that the motor turns,
    and the torque at the joint over the motor's. laws: of the planets' meshes.
    """

    name = "exudyn"

    def __init__(self, robot: Robot, level: Level, laws: Switches = MESH_LAWS) -> None:
        super().__init__(robot, level)
        self.laws = laws
        self._axis_rotations = [_rotation_to_axis(joint.axis) for joint in robot.joints]
        self.parts = [self._link(number) for number in range(len(robot.joints))]
        factors, offsets = robot.joint_map
        springs = robot.mesh_coordinates if level == "geared" else 0
        self.rows = np.hstack([factors, np.zeros((len(factors), springs))])
        self.motors = {joint: (joint, 1.0) for joint in robot.coordinates}
        self._rotor_meshes: list[MeshPlaces] = []
        self._stages: list[tuple[PlanetaryStage, int, int]] = []  # gears, link, sun
        self._diagonal = [joint.armature * (level != "links") for joint in robot.joints]
        for rotor in robot.rotors:
            self._add_rotor(rotor)
        for stage, columns in zip(robot.stages, robot.stage_columns, strict=True):
            self._add_stage(stage, columns)
        self.drive = np.array([self.rows[place] / ratio for place, ratio in self.motors.values()])
        links = len(robot.joints)
        self._angle_rows = self.rows.copy()
        self._angle_rows[links:, : len(robot.coordinates)] = 0.0
        self._offsets = np.array([*offsets, *[0.0] * (len(self.parts) - links)])

    def _add_rotor(self, rotor: Rotor) -> None:
        """Add a rotor to the tree, or what it reflects to the diagonal of M."""
        if self.level == "armature":
            self._diagonal[rotor.joint] += rotor.inertia * rotor.ratio**2
        if self.level not in WITH_ROTORS:
            return
        frame, turns = self.robot.frames[rotor.stator], rotor.ratio * self.rows[rotor.joint]
        if self.level == "geared" and rotor.mesh:
            column = len(self.robot.coordinates) + len(self._rotor_meshes)
            turns[column] = 1 / rotor.mesh.pinion_base_radius_m
            at = len(self.parts), rotor.joint, rotor.ratio
            self._rotor_meshes.append(MeshPlaces(*at, rotor.mesh))
            self._move_motor(rotor.joint, rotor.ratio)
        rotation = self._pose_in_body(frame)[0] @ _rotation_to_axis(rotor.axis)
        self._add_spinning_part(frame.body, rotation, rotor.inertia, turns)

    def _add_stage(self, stage: JointStage, columns: slice) -> None:
        """Add sun and planets to the tree, or what they reflect to the diagonal of M."""
        gears, moved, is_elastic = stage.gears, stage.joint, self.level == "geared"
        r_s, r_p = (base_radius(gears, each) for each in (gears.sun_teeth, gears.planet_teeth))
        sun_turns = 1 + gears.ring_teeth / gears.sun_teeth
        planet_turns = -gears.ring_teeth / gears.planet_teeth  # on the carrier
        J_s, J_p = inertia(gears, "sun"), inertia(gears, "planet")
        if self.level == "armature":
            spun = gears.planet_count * J_p * (1 + planet_turns) ** 2
            self._diagonal[moved] += J_s * sun_turns**2 + spun
        if self.level not in WITH_ROTORS:
            return
        x_sp, x_pr = np.zeros((2, gears.planet_count, self.rows.shape[1]))
        if is_elastic:
            for planet in range(gears.planet_count):
                x_sp[planet, columns] = stage.displacement("x_sp", planet)
                x_pr[planet, columns] = stage.displacement("x_pr", planet)
            self._stages.append((gears, moved, len(self.parts)))
            self._move_motor(moved, sun_turns)
        link, under = self.rows[moved], self.parts[moved]
        turns = sun_turns * link + (x_sp[0] + x_pr[0]) / r_s
        self._add_spinning_part(under.parent, under.rotation, J_s, turns)
        for x in x_pr:
            self._add_spinning_part(moved, np.eye(3), J_p, planet_turns * link - x / r_p)

    def _move_motor(self, joint: int, ratio: float) -> None:
        """Let the motor of a joint, if it is free, turn the part that is added next."""
        if joint in self.motors:
            self.motors[joint] = len(self.parts), ratio

    def _add_spinning_part(
        self, body: int, rotation: np.ndarray, inertia: float, turns: np.ndarray
    ) -> None:
        """Add what spins on a body, about z of this rotation in its turned frame.

        turns (n,): its rate by those of the coordinates.
        """
        spinning, at = np.diag([0.0, 0.0, inertia]), np.zeros(3)
        self.parts.append(TreePart(TURNING, body, rotation, at, NO_MASS, at, spinning))
        self.rows = np.vstack([self.rows, turns])

    @cached_property
    def meshes(self) -> list[TreeMesh]:
        """The meshes of elastic stages, planet by planet, the sun's before the ring's."""
        # Compiled laws take half a second to import, and most robots have no stage.
        from crosscheck.models.exudyn.tree.laws import build_mesh_law
        from crosscheck.models.exudyn.tree.mesh import NO_SUN, TreeMesh

        return [
            TreeMesh(
                build_mesh_law(gears, self.laws, "ring" if wheel == NO_SUN else "sun", number),
                number,
                link,
                wheel,
                sun + 1 + number,
            )
            for gears, link, sun in self._stages
            for number in range(gears.planet_count)
            for wheel in (sun, NO_SUN)
        ]

    @cached_property
    def _heavy(self) -> Engine:
        """The tree with its weights, and sensors."""
        return Engine(
            self.parts, self.robot.gravity, diagonal=self._diagonal, sensors=self._sensors()
        )

    @cached_property
    def _weightless(self) -> Engine:
        """The tree without any force."""
        return Engine(self.parts, np.zeros(3), diagonal=self._diagonal)

    @cached_property
    def _elastic(self) -> Engine:
        """The tree with weights, meshes and friction."""
        return self.build_engine(self._build_mesh_function())

    def build_engine(self, force: UserFunction | None, clock: list[float] | None = None) -> Engine:
        """The tree with weights, friction and a force, which may look at the engine's clock."""
        friction = [joint.friction for joint in self.robot.joints]
        return Engine(
            self.parts,
            self.robot.gravity,
            force=force,
            clock=clock,
            friction=friction,
            diagonal=self._diagonal,
        )

    def _build_mesh_function(self) -> UserFunction | None:
        """User function with the meshes' torques on links, rotors, suns and planets."""
        stages = None
        if self._stages:
            from crosscheck.models.exudyn.tree.loads import build_load_function, write_mesh_loads
            from crosscheck.models.exudyn.tree.mesh import build_gearing

            gearing = build_gearing(self.meshes, self.laws.mesh_work == "conservative", whole=False)
            stages = build_load_function(write_mesh_loads, (gearing,), len(self.parts), [0.0])
        return _join_rotors(self._rotor_meshes, stages) if self._rotor_meshes else stages

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """Mass matrix over the free coordinates (states, n, n), from Exudyn's."""
        matrices = []
        for at in q @ self._angle_rows.T + self._offsets:
            self._weightless.put(at, 0 * at)
            matrices.append(self.rows.T @ self._weightless.mass_matrix() @ self.rows)
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
        left = torques @ self.drive - self._holding_forces(self._elastic, q, v)
        return np.linalg.solve(self.mass_matrix(q), left[:, :, None])[:, :, 0]

    def stage_forces(self, q: np.ndarray) -> np.ndarray:
        """Forces (states, meshes) [N] of the springs of every planet, by angles of the tree."""
        from crosscheck.models.exudyn.tree.mesh import build_gearing, read_meshes

        angles, times = q @ self._angle_rows.T + self._offsets, np.zeros(len(q))
        gearing = build_gearing(self.meshes, False, whole=False)
        return read_meshes(gearing, times, angles, 0 * angles)[2].T

    def energy(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Energy (states,) [J]: kinetic by Exudyn's M, the weights' by sensors of its bodies."""
        total: np.ndarray = np.einsum("si,sij,sj->s", v, self.mass_matrix(q), v) / 2
        weights = np.array([part.mass * self.robot.gravity for part in self.parts])
        places = np.array(list(self._sensor_values(q, v, kinds=1))).reshape(-1, *weights.shape)
        return total - (places * weights).sum(axis=(1, 2))

    def momentum(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Linear, then angular momentum (states, 6), by Exudyn's sensors of its bodies."""
        total = np.zeros((len(q), 6))
        for momentum, values in zip(total, self._sensor_values(q, v), strict=True):
            for part, (at, velocity, rate, rotation) in zip(self.parts, values, strict=True):
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
        for at in q @ self._angle_rows.T + self._offsets:
            self._heavy.put(at, 0 * at)
            positions.append(
                self._heavy.system.GetSensorValues(len(self.parts) * len(SENSOR_VARIABLES))
            )
        return np.array(positions)

    def _sensors(self) -> list[Any]:
        """Sensors of every body, and one of the tip's place unless it stands on the ground."""
        frame = self.robot.frames[self.robot.tip]
        points = [
            (n, part.com, kind) for n, part in enumerate(self.parts) for kind in SENSOR_VARIABLES
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
        states = zip(q @ self._angle_rows.T + self._offsets, v @ self.rows.T, strict=True)
        every = range(0, len(self.parts) * len(SENSOR_VARIABLES), len(SENSOR_VARIABLES))
        for at, rate in states:
            self._heavy.put(at, rate)
            measure = self._heavy.system.GetSensorValues
            yield [[np.array(measure(first + kind)) for kind in range(kinds)] for first in every]

    def _holding_forces(self, system: Engine, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Generalized forces against which nothing in a system accelerates (states, n)."""
        forces = []
        for at, rate in zip(q @ self._angle_rows.T + self._offsets, v @ self.rows.T, strict=True):
            system.put(at, rate)
            forces.append(-system.right_hand_side() @ self.rows)
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
            body.mass or NO_MASS,
            axis_rotation.T @ body.com,
            axis_rotation.T @ body.inertia @ axis_rotation,
        )

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


def _join_rotors(meshes: Sequence[MeshPlaces], others: UserFunction | None) -> UserFunction:
    """User function with the meshes' torques on rotors and joints, beside those of others."""

    def torques(
        system: object, time: float, item: int, angles: list[float], rates: list[float]
    ) -> list[float]:
        efforts = others(system, time, item, angles, rates) if others else [0.0] * len(angles)
        for place, joint, ratio, mesh in meshes:
            lever, play = mesh.pinion_base_radius_m, mesh.backlash_m
            ahead = lever * angles[place]
            pressed = max(ahead - play, 0.0) + min(ahead + play, 0.0)
            if pressed:
                damped = mesh.damping_N_s_per_m * lever * (rates[place] - ratio * rates[joint])
                moment = lever * (mesh.stiffness_N_per_m * pressed + damped)
                efforts[place] -= moment
                efforts[joint] += ratio * moment
        return efforts

    return torques
