"""A robot by Kane's method: partial velocities of every body, for many states side by side.

T. R. Kane and D. A. Levinson, Dynamics: Theory and Applications, McGraw-Hill, 1985, chapter 4.
Of a body with centre of mass c, angular velocity w = W v and V its velocity per rate, the
generalized inertia forces are m V' a_c + W' (I alpha + w x I w). Of a balanced rotor only its spin
s = c' v about the axis z counts, c = N e + W' z of its stator: c J ds/dt + J s W' (w x z). Where it
has a mesh, its rate against the stator is N q' + x' / r, and the mesh's force does work on x alone.
Sun and planets of a stage are such rotors on the link that holds the ring (Eqs. 2, 3 of the paper).
The force of a mesh whose stiffness and error vary with the joint's angle does work on that as well.
Friction takes c times a joint's rate from that joint, and so from the coordinate that moves it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, wraps
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.derivation.gears import (
    Gears,
    PlacedStage,
    displacement_rows,
    gather_gears,
)
from crosscheck.analytic.derivation.stage import gear_masses
from crosscheck.analytic.paper import stiffness
from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.analytic.paper.mesh_force import dead_zone, is_in_contact, phase_force, total_error
from crosscheck.analytic.robot.runs import run_precisely, run_robot
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import BASE, MESH_LAWS, WITH_ROTORS, JointStage, Level, Robot

UPRIGHT = np.eye(3)
BLOCK = 2**14  # states x bodies x joints at a time: more would leave the processor's cache
NEXT, LAST = np.array([1, 2, 0]), np.array([2, 0, 1])  # axes after x, y, z, and after these


def split_states(method: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """Wrap a method of a model so that it gets many states (states, n) in blocks."""

    @wraps(method)
    def take_blocks(self: AnalyticRobot, *states: np.ndarray) -> np.ndarray:
        count = 1 + len(states[0]) * len(self.robot.joints) ** 2 // BLOCK
        if count == 1:
            return method(self, *states)
        blocks = zip(*(np.array_split(each, count) for each in states), strict=True)
        return np.concatenate([method(self, *block) for block in blocks])

    return take_blocks


class FramePoses(NamedTuple):
    """Poses of all frames in every state, and their partial velocities.

    rotation (states, bodies, 3, 3); position and axis of the joint (states, bodies, 3); the body's
    inertia in space (states, bodies, 3, 3), its centre of mass from the origin (states, bodies, 3);
    partials (states, bodies, 3, n): angular velocity and that of the centre of mass, per rate of
    each coordinate.
    """

    rotation: np.ndarray
    position: np.ndarray
    axis: np.ndarray
    inertia: np.ndarray
    com_lever: np.ndarray
    angular_partials: np.ndarray
    com_partials: np.ndarray


class FrameRates(NamedTuple):
    """Rates of all frames in every state, each (states, bodies, 3).

    Angular velocity; angular acceleration and that of the origin without v'.
    """

    angular: np.ndarray
    angular_rate: np.ndarray
    acceleration: np.ndarray


class SpinningBody(NamedTuple):
    """A balanced body that spins on another: a rotor, a sun, or the planets of a stage together.

    body: the one under it, or BASE; axis (3,): in that one's frame; turns (n,): its rate against
    that one, per rate of each coordinate.
    """

    body: int
    axis: np.ndarray
    inertia: float
    turns: np.ndarray


class PlanetMeshStates(NamedTuple):
    """States of planets' meshes (states, meshes): x - e, k, and slopes of k and e by the phase."""

    gap: np.ndarray
    stiffness: np.ndarray
    slopes: tuple[np.ndarray, np.ndarray]


class AnalyticRobot(RobotModel):
    """A robot by the project's own derivation, Kane's method, in NumPy."""

    name = "analytic"

    def __init__(self, robot: Robot, level: Level) -> None:
        super().__init__(robot, level)
        free = robot.coordinates
        meshes = robot.meshes if level == "geared" else ()
        stages = robot.stages if level == "geared" else ()
        size = len(free) + (robot.mesh_coordinates if level == "geared" else 0)
        factors, self._offset = robot.joint_map
        self._share = np.zeros((len(factors), size))
        self._share[:, : len(free)] = factors
        self._add_bodies(robot)
        self._friction = np.array([joint.friction for joint in robot.joints])
        armature = [joint.armature * (level != "links") for joint in robot.joints]
        self._armature = self._share.T * armature @ self._share
        self._meshes = [mesh for _, mesh in meshes]
        self._spinning_bodies: list[SpinningBody] = []
        self.drive = np.eye(len(free), size)  # generalized forces, per torque of each motor
        place = len(free)
        for rotor in robot.rotors:
            turns = rotor.ratio * self._share[rotor.joint]
            if meshes and rotor.mesh:
                turns[place] = 1 / rotor.mesh.pinion_base_radius_m
                place += 1
                if rotor.joint in free:
                    self.drive[free.index(rotor.joint)] = turns / rotor.ratio
            frame = robot.frames[rotor.stator]
            axis = frame.placement.rotation @ rotor.axis
            self._spinning_bodies.append(SpinningBody(frame.body, axis, rotor.inertia, turns))
        for stage, columns in zip(robot.stages, robot.stage_columns, strict=True):
            self._add_stage(stage, columns if stages else None)

    @cached_property
    def _gears(self) -> Gears:
        """The meshes of planetary stages, where teeth give way."""
        stages = self.robot.stages if self.level == "geared" else ()
        placed = [
            PlacedStage(stage.gears, stage.joint, columns.start, stage.has_free_planets)
            for stage, columns in zip(stages, self.robot.stage_columns, strict=False)
        ]
        return gather_gears(placed, range(len(self.robot.joints)), MESH_LAWS)

    @cached_property
    def _mesh_rows(self) -> np.ndarray:
        """Displacements of these meshes by the coordinates."""
        return displacement_rows(self._gears, self._share.shape[1])

    def _add_bodies(self, robot: Robot) -> None:
        """Add the numbers of all joints and bodies, side by side; joint k moves body k."""
        joints, bodies = robot.joints, robot.bodies
        self._axes = np.array([joint.axis for joint in joints])
        once = cross(UPRIGHT[None], self._axes[:, None], axis=2)  # times u: axis x u
        self._crossings = once, once @ once
        self._places = np.array([joint.placement.position for joint in joints])
        self._rotations = np.array([joint.placement.rotation for joint in joints])
        self._turns = np.array([joint.kind == "revolute" for joint in joints])
        self._masses = np.array([[body.mass] for body in bodies])
        self._coms = np.array([body.com for body in bodies])
        self._inertias = np.array([body.inertia for body in bodies])
        self._parents = np.eye(len(joints) + 1)[[joint.parent for joint in joints], :-1]
        self._paths = np.linalg.inv(np.eye(len(joints)) - self._parents)  # 1 at joints that move it

    def _add_stage(self, stage: JointStage, columns: slice | None) -> None:
        """Add sun and planets of a stage; columns: of its coordinates; None if gears are rigid."""
        gears, joint, share = stage.gears, self.robot.joints[stage.joint], self._share[stage.joint]
        geometry, (M_s, M_p) = stage_geometry(gears), gear_masses(gears)
        axis = joint.placement.rotation @ joint.axis
        J_s, J_p = M_s * geometry.r_s**2, M_p * geometry.r_p**2
        each = gears.planet_count // len(stage.groups)  # planets that move as one
        for number in stage.groups:
            x_sp, x_pr = np.zeros((2, share.size))
            if columns is not None:
                x_sp[columns] = stage.displacement("x_sp", number)
                x_pr[columns] = stage.displacement("x_pr", number)
            planet = -(x_pr + geometry.r_cp * share) / geometry.r_p
            self._spinning_bodies.append(SpinningBody(joint.parent, axis, each * J_p, planet))
        sun = (x_sp + x_pr + 2 * geometry.r_cp * share) / geometry.r_s
        self._spinning_bodies.append(SpinningBody(joint.parent, axis, J_s, sun))
        if columns is not None and joint.mimic is None:
            self.drive[self.robot.coordinates.index(stage.joint)] = sun / geometry.n

    @split_states
    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """Mass matrix M (states, n, n), by the bodies' rates and momenta."""
        return self._mass(self._poses(q))

    @split_states
    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal torques (states, n): inertia forces without accelerations."""
        return self._bias_and_weight(self._poses(q), v, np.zeros(3))

    @split_states
    def gravity(self, q: np.ndarray) -> np.ndarray:
        """Torques that hold the bodies' weights (states, n)."""
        return self._weight(self._poses(q))

    def terms(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """M, bias and gravity of the same states."""
        poses = self._poses(q)
        return self._mass(poses), self._bias_and_weight(poses, v, np.zeros(3)), self._weight(poses)

    def frames(self, q: np.ndarray, v: np.ndarray) -> tuple[list[FramePoses], list[FrameRates]]:
        """Pose of each body at q, and its rates at v, both (states, n), on a base at rest."""
        poses = self._poses(q)
        parts = zip(*(part.swapaxes(0, 1) for part in poses), strict=True)
        rates = zip(*np.moveaxis(np.array(self._rates(poses, v, np.zeros(3))), 2, 1), strict=True)
        return [FramePoses(*each) for each in parts], [FrameRates(*each) for each in rates]

    @split_states
    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Generalized forces M a + bias + gravity, of meshes and of friction (states, n)."""
        poses = self._poses(q)
        held = self._bias_and_weight(poses, v, self.robot.gravity) + self._mesh_force(q, v)
        held += self._friction_force(v)
        return multiply(self._mass(poses), a) + held

    @split_states
    def forward_dynamics(self, q: np.ndarray, v: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """Accelerations under torques of motors (states, n), by solving with M."""
        poses = self._poses(q)
        held = self._bias_and_weight(poses, v, self.robot.gravity) + self._mesh_force(q, v)
        held += self._friction_force(v)
        left = torques @ self.drive - held
        return np.linalg.solve(self._mass(poses), left[:, :, None])[:, :, 0]

    def integrate(self, scenario: Scenario) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates (records, n) of a run by the kernel. Raises Diverged."""
        return run_robot(self, scenario)

    def precise(self, scenario: Scenario, rtol: float) -> tuple[np.ndarray, np.ndarray]:
        """The same at a relative tolerance, steps ended at contact changes. Raises Diverged."""
        return run_precisely(self, scenario, rtol)

    def stage_forces(self, q: np.ndarray) -> np.ndarray:
        """Forces (states, meshes) [N] of the springs of every planet, by the laws of its meshes."""
        gears, (gap, k, _) = self._gears, self._planet_mesh_states(q)
        pairs = (k * dead_zone(gap, gears.b)).reshape(len(q), -1, 2)
        return np.repeat(pairs, gears.planets[::2].astype(int), axis=1).reshape(len(q), -1)

    @split_states
    def energy(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Energy (states,) [J]: v' M v / 2 plus the potential energy of the weights."""
        poses = self._poses(q)
        total: np.ndarray = (v * multiply(self._mass(poses), v)).sum(axis=1) / 2
        total -= ((poses.position + poses.com_lever) @ self.robot.gravity) @ self._masses[:, 0]
        return total

    @split_states
    def momentum(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Linear, then angular momentum (states, 6), by the partial velocities."""
        poses, total = self._poses(q), np.zeros((len(q), 6))
        linear = self._masses * multiply(poses.com_partials, v[:, None])
        angular = cross(poses.position + poses.com_lever, linear, axis=2)
        angular += multiply(poses.inertia, multiply(poses.angular_partials, v[:, None]))
        total[:, :3] += linear.sum(axis=1)
        total[:, 3:] += angular.sum(axis=1)
        for spinner in self._spinning_bodies if self.level in WITH_ROTORS else ():
            axis, spin = self._spin(spinner, poses)
            total[:, 3:] += spinner.inertia * (spin * v).sum(axis=1, keepdims=True) * axis
        return total

    def tip(self, q: np.ndarray) -> np.ndarray:
        """Position of the tip (states, 3) [m], by the chain of frames."""
        frame = self.robot.frames[self.robot.tip]
        if frame.body == BASE:
            return np.tile(frame.placement.position, (len(q), 1))
        rotation, position = (part[:, frame.body] for part in self._poses(q)[:2])
        return position + rotation @ frame.placement.position

    def _mass(self, poses: FramePoses) -> np.ndarray:
        momenta = [
            _flatten(self._masses[:, None] * poses.com_partials),
            _flatten(poses.inertia @ poses.angular_partials),
        ]
        rates = [_flatten(poses.com_partials), _flatten(poses.angular_partials)]
        for spinner in self._spinning_bodies:
            if self.level == "armature":
                spin = np.broadcast_to(spinner.turns, (len(rates[0]), spinner.turns.size))
            elif self.level in WITH_ROTORS:
                _, spin = self._spin(spinner, poses)
            else:
                continue
            rates.append(spin[:, None])
            momenta.append(spinner.inertia * spin[:, None])
        left, right = np.concatenate(rates, axis=1), np.concatenate(momenta, axis=1)
        mass: np.ndarray = left.transpose(0, 2, 1) @ right + self._armature
        return mass

    def _weight(self, poses: FramePoses) -> np.ndarray:
        weights: np.ndarray = (self._masses * self.robot.gravity).ravel()
        return -weights @ _flatten(poses.com_partials)

    def _bias_and_weight(self, poses: FramePoses, v: np.ndarray, gravity: np.ndarray) -> np.ndarray:
        """Torques under which nothing accelerates (states, n): weights are a base that rises."""
        rates = self._rates(poses, v, -gravity)
        turned = _lever_acceleration(*rates[:2], poses.com_lever)
        force = self._masses * (rates.acceleration + turned)
        moment = multiply(poses.inertia, rates.angular_rate)
        moment += cross(rates.angular, multiply(poses.inertia, rates.angular), axis=2)
        total = project(_flatten(poses.com_partials), _flatten(force[..., None])[..., 0])
        total += project(_flatten(poses.angular_partials), _flatten(moment[..., None])[..., 0])
        for spinner in self._spinning_bodies:
            if spinner.body == BASE or self.level not in WITH_ROTORS:
                continue
            axis, spin = self._spin(spinner, poses)
            speed = (spin * v).sum(axis=1, keepdims=True)
            growth = (axis * rates.angular_rate[:, spinner.body]).sum(axis=1, keepdims=True)
            carried = cross(rates.angular[:, spinner.body], axis)
            turned = project(poses.angular_partials[:, spinner.body], carried)
            total += spinner.inertia * (growth * spin + speed * turned)
        return total

    def _friction_force(self, v: np.ndarray) -> np.ndarray:
        """The share of friction of all joints in the generalized forces (states, n)."""
        return v @ self._share.T * self._friction @ self._share

    def _mesh_force(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """The share of the meshes' springs and dampers in the generalized forces (states, n)."""
        total, first = np.zeros_like(q), len(self.robot.coordinates)
        for place, mesh in enumerate(self._meshes, first):
            x, rate, play = q[:, place], v[:, place], mesh.backlash_m
            force = mesh.stiffness_N_per_m * (x - np.clip(x, -play, play))
            force += mesh.damping_N_s_per_m * rate
            total[:, place] = np.where(np.abs(x) > play, force, 0.0)
        if not self._gears.x_index.size:
            return total
        gears, (gap, k, slopes) = self._gears, self._planet_mesh_states(q)
        pulls = gears.planets * k * dead_zone(gap, gears.b)
        pulls += np.where(is_in_contact(gap, gears.b), gears.d * (v @ self._mesh_rows.T), 0.0)
        turned = gears.planets * gears.rate * phase_force(gap, k, *slopes, gears.b)
        return total + pulls @ self._mesh_rows - turned @ self._share[gears.theta]

    def _planet_mesh_states(self, q: np.ndarray) -> PlanetMeshStates:
        """States of the teeth of each free planet, sun mesh before ring mesh."""
        g = self._gears
        angle = q @ self._share[g.theta].T + self._offset[g.theta]
        phase = g.rate * angle + g.offset
        gap = q @ self._mesh_rows.T - total_error(phase, g.E, g.error_phase, g.static_error)
        k, k_slope = np.zeros((2, *phase.shape))
        for i, turn in enumerate(phase.T):
            k[:, i] = stiffness.stiffness(g.law, i, turn, g.k_m[i], g.k_a[i])
            k_slope[:, i] = stiffness.stiffness_slope(g.law, i, turn, g.k_a[i])
        return PlanetMeshStates(gap, k, (k_slope, g.E * np.cos(phase + g.error_phase)))

    def _poses(self, q: np.ndarray) -> FramePoses:
        """Poses of every body, and their partial velocities."""
        values = q @ self._share.T + self._offset
        angles = np.where(self._turns, values, 0.0)[:, :, None, None]
        once, twice = self._crossings
        turned = np.sin(angles) * once + (1 - np.cos(angles)) * twice + UPRIGHT  # Rodrigues
        slid = np.where(self._turns, 0.0, values)[:, :, None] * self._axes
        rotation = self._rotations @ turned
        position = self._places + multiply(self._rotations, slid)
        for number, joint in enumerate(self.robot.joints):
            if joint.parent != BASE:
                under, at = rotation[:, joint.parent], position[:, number]
                position[:, number] = position[:, joint.parent] + multiply(under, at)
                rotation[:, number] = under @ rotation[:, number]
        axis, arm = multiply(rotation, self._axes), multiply(rotation, self._coms)
        inertia = rotation @ self._inertias @ rotation.swapaxes(2, 3)
        across, origins = np.array([axis, position]).swapaxes(2, 3).copy()[:, :, None]
        turning = across * (self._paths * self._turns)[:, None]
        away = (position + arm)[:, :, :, None] - origins
        moving = cross(turning, away, axis=2) + across * (self._paths * ~self._turns)[:, None]
        columns = np.array([turning, moving]).reshape(-1, len(self._turns)) @ self._share
        partials = columns.reshape(2, *moving.shape[:3], self._share.shape[1])
        return FramePoses(rotation, position, axis, inertia, arm, *partials)

    def _rates(self, poses: FramePoses, v: np.ndarray, rising: np.ndarray) -> FrameRates:
        """Rates of every body; rising (3,): acceleration of the base."""
        turns = self._turns[:, None]
        relative = (v @ self._share.T)[:, :, None] * poses.axis
        angular = self._paths @ np.where(turns, relative, 0.0)
        turned = cross(self._parents @ angular, relative, axis=2)
        growth = self._paths @ np.where(turns, turned, 0.0)
        under = self._parents @ angular, self._parents @ growth
        at = poses.position - self._parents @ poses.position
        gained = _lever_acceleration(*under, at) + np.where(turns, 0.0, 2 * turned)
        return FrameRates(angular, growth, self._paths @ gained + rising)

    def _spin(self, spinner: SpinningBody, poses: FramePoses) -> tuple[np.ndarray, np.ndarray]:
        """Axis of a spun body in space (states, 3), and its spin per rate (states, n)."""
        states = len(poses.position)
        if spinner.body == BASE:
            return np.tile(spinner.axis, (states, 1)), np.tile(spinner.turns, (states, 1))
        turned = poses.rotation[:, spinner.body] @ spinner.axis
        return turned, spinner.turns + project(poses.angular_partials[:, spinner.body], turned)


def _lever_acceleration(angular: np.ndarray, growth: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Accelerations of points by turning, arm (states, bodies, 3) from the origins."""
    inward: np.ndarray = cross(angular, cross(angular, arm, axis=2), axis=2)
    return cross(growth, arm, axis=2) + inward


def _flatten(columns: np.ndarray) -> np.ndarray:
    """Columns of all bodies (states, bodies, 3, n), one body below the other (states, rows, n)."""
    states, bodies, rows, n = columns.shape
    return columns.reshape(states, bodies * rows, n)


def cross(left: np.ndarray, right: np.ndarray, axis: int = 1) -> np.ndarray:
    """one x other (states, 3); of one (states, 3, n), for each of its columns.

    axis: on which the three components are.
    """
    right = right if left.ndim == right.ndim else right[:, :, None]
    product: np.ndarray = left.take(NEXT, axis) * right.take(LAST, axis)
    product -= left.take(LAST, axis) * right.take(NEXT, axis)
    return product


def multiply(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Matrices (..., i, j) times vectors (..., j)."""
    product: np.ndarray = (matrix @ vector[..., None])[..., 0]
    return product


def project(columns: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Columns (states, rows, n), transposed, times force (states, rows): (states, n)."""
    product: np.ndarray = (force[:, None] @ columns)[:, 0]
    return product
