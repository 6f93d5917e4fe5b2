"""Exudyn model: every link, sun and planet a free rigid body, held by joints, pushed by teeth.

Bodies and their poses are in ``models.exudyn.bodies.poses``, the contact of two gears, which sees
nothing but poses, in ``models.exudyn.bodies.contact``. The engine holds the bodies together by
constraints.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from crosscheck.models.arm.arm import Arm, Joint, Planetary
from crosscheck.models.errors import Diverged
from crosscheck.models.experiment.drive import DriveData, joint_torque, torques_along
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.exudyn.bodies import contact, poses
from crosscheck.models.exudyn.bodies.contact import ContactMesh, build_contact_mesh
from crosscheck.models.exudyn.bodies.engine import BodyEngine, Connector
from crosscheck.models.interface import STATE_ABILITIES, require_finite
from crosscheck.models.robot.arm_model import ArmModel
from crosscheck.models.trajectory import MESH_VARIABLES, recorded_times, trajectory

if TYPE_CHECKING:
    import xarray as xr


GROUND_STATE = (0.0, 0.0, 0.0)  # pose and velocity of the ground


class GearPair(NamedTuple):
    """A mesh and its four bodies: planet, carrier, wheel, previous link (for a ring, three)."""

    mesh: ContactMesh
    bodies: tuple[int, ...]


def build_gear_pairs(arm: Arm, chosen: Switches) -> list[list[list[GearPair]]]:
    """The meshes by joint, side (sun, ring; none of a direct joint) and planet."""
    pairs: list[list[list[GearPair]]] = []
    for number, (stage, joint) in enumerate(zip(poses.build_stages(arm), arm.joints, strict=True)):
        pairs.append([])
        if not isinstance(joint, Planetary):
            continue
        ring_at = poses.ring_seat(arm, number)
        sides: tuple[contact.Side, contact.Side] = ("sun", "ring")
        for side, wheel in zip(sides, ((stage.driven,), ()), strict=True):
            bodies = [(planet, stage.link, *wheel, stage.previous) for planet in stage.planets]
            meshes = (
                build_contact_mesh(joint, chosen, side, ring_at, n) for n in range(len(bodies))
            )
            pairs[-1].append([GearPair(*each) for each in zip(meshes, bodies, strict=True)])
    return pairs


def build_tooth_connector(pair: GearPair) -> Connector:
    """Connector of one mesh's forces on its moving bodies; the ground bears what acts on it."""
    moving = tuple(body for body in pair.bodies if body != poses.GROUND)
    mesh, ground, size = pair.mesh, GROUND_STATE * (poses.GROUND in pair.bodies), 3 * len(moving)

    def force(_: object, t: float, _item: int, q: list[float], q_t: list[float]) -> list[float]:
        forces = contact.push_bodies(mesh, t, np.array([*q, *ground]), np.array([*q_t, *ground]))
        return forces[:size].tolist()

    return Connector(moving, force)


def build_motor_connector(
    stage: poses.StageBodies, joint: Joint, law: DriveData, place: int
) -> Connector:
    """Connector of one joint's motor and friction, both acting back on the previous body.

    The motor turns the sun, or the link without gears, by T / n; friction acts on the link. T and
    friction are those of the link's angle and rate.
    """
    ratio = joint.ring_teeth / joint.sun_teeth + 1 if isinstance(joint, Planetary) else 1.0
    grounded, friction = stage.previous == poses.GROUND, joint.friction_N_m_s_per_rad
    turning = tuple(dict.fromkeys((stage.driven, stage.link)))
    moving = turning if grounded else (*turning, stage.previous)
    link = 3 * len(turning) - 1
    gains, table = law.gains[place], law.table_torque[place]

    def force(_: object, t: float, _item: int, q: list[float], q_t: list[float]) -> list[float]:
        theta, theta_dot = q[link], q_t[link]
        if not grounded:
            theta, theta_dot = theta - q[-1], theta_dot - q_t[-1]
        torque = joint_torque(law.code, gains, law.table_time, table, t, theta, theta_dot)
        on_driven, drag = torque / ratio, friction * theta_dot
        torques = [0.0] * len(q)
        torques[2] += on_driven
        torques[link] -= drag
        if not grounded:
            torques[-1] = drag - on_driven
        return torques

    return Connector(moving, force)


class ExudynBodies(ArmModel):
    """The geared arm in redundant coordinates: three per body, and two constraints per joint.

    Coordinates are the paper's (Eq. 20), or those of free planets; a state has all joints closed,
    and lumped planets of a stage alike. The bodies' mass matrix, forces, constraints and motion are
    the engine's.
    """

    name, level = "exudyn:bodies", "geared"
    abilities = frozenset({*STATE_ABILITIES, "simulate", "constraint_residual"})
    takes_many_states = False

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        self.stages = poses.build_stages(arm)
        self.poses = poses.PoseMap(arm, self.layout)
        self.meshes = build_gear_pairs(arm, self.switches)

    @cached_property
    def free_engine(self) -> BodyEngine:
        """Engine of the bodies on their joints without any force."""
        return self._engine([], gravity=(0.0, 0.0))

    @cached_property
    def driven_engine(self) -> BodyEngine:
        """Engine of the bodies on their joints with meshes, motors, friction and gravity."""
        motors = [
            build_motor_connector(stage, joint, self._drive, place)
            for place, (stage, joint) in enumerate(zip(self.stages, self.arm.joints, strict=True))
        ]
        contacts = [
            build_tooth_connector(pair) for joint in self.meshes for side in joint for pair in side
        ]
        return self._engine(motors + contacts, self.arm.gravity_m_per_s2)

    def _engine(self, connectors: Sequence[Connector], gravity: tuple[float, float]) -> BodyEngine:
        zero = self.poses.pose(np.zeros(len(self.layout)))
        return BodyEngine(poses.build_bodies(self.arm), connectors, gravity, zero)

    def _place_engine(
        self, engine: BodyEngine, t: float, q: np.ndarray, v: np.ndarray
    ) -> BodyEngine:
        engine.place(t, self.poses.pose(q), self.poses.velocity(q, v))
        return engine

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M(q) = J^T M J, shape (n, n), J the derivative of the poses by q."""
        jacobian = self.poses.jacobian(q)
        mass = self._place_engine(self.free_engine, 0.0, q, np.zeros_like(q)).mass_matrix()
        return jacobian.T @ mass @ jacobian

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """C(q, v) v = J^T (M J' v - f), shape (n,), f the engine's inertial forces."""
        engine = self._place_engine(self.free_engine, 0.0, q, v)
        swing = self.poses.acceleration(q, v, np.zeros_like(v))
        inertial = engine.mass_matrix() @ swing - engine.right_hand_side()
        return self.poses.jacobian(q).T @ inertial

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Generalized force at t [s], shape (n,): drive, meshes, dampers, friction and gravity."""
        return self.poses.jacobian(q).T @ self.body_forces(t, q, v)

    def body_forces(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Forces [N], and torques [N m] about their origins, on the bodies, (3 bodies,).

        Of teeth, motors, friction and gravity.
        """
        driven, free = (
            self._place_engine(engine, t, q, v) for engine in (self.driven_engine, self.free_engine)
        )
        return driven.right_hand_side() - free.right_hand_side()

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q'' at t [s], shape (n,), from the engine's constrained equations of all bodies."""
        return self.poses.coordinates(self.body_accelerations(t, q, v)[2::3])

    def body_accelerations(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Accelerations of x, y and angle of every body at t [s], shape (3 bodies,)."""
        return self.driven_engine.solve(t, self.poses.pose(q), self.poses.velocity(q, v))[0]

    def constraint_residual(
        self, q: np.ndarray, v: np.ndarray, a: np.ndarray, opened: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """How far open the joints are at q, v, a: gaps [m], rates, accelerations, (2 joints,) each.

        The engine evaluates its own constraints at this model's poses, or with the bodies displaced
        apart so far, without turning.
        """
        engine, pose, velocity = self.free_engine, self.poses.pose(q), self.poses.velocity(q, v)
        acceleration = self.poses.acceleration(q, v, a)
        swing = engine.swing(0.0, pose, velocity)
        engine.place(0.0, pose, velocity)
        jacobian = engine.joint_jacobian()
        if opened is not None:
            along = np.arange(pose.size) % 3 != 2  # x and y of every body, one joint for each
            shifts = np.zeros((3, pose.size))
            shifts[:, along] = np.linalg.solve(jacobian[:, along], opened.T).T
            pose, velocity = pose + shifts[0], velocity + shifts[1]
            acceleration = acceleration + shifts[2]
            engine.place(0.0, pose, velocity)
        gaps, rates = engine.joints(), engine.joints(velocity_level=True)
        return gaps, rates, jacobian @ acceleration + swing

    def simulate(self) -> xr.Dataset:
        """Run the scenario by the trapezoidal rule at its step, all of it in the engine.

        Meant for some milliseconds: 4.5 kHz are resolved to 1e-4 at 1 us. Mesh variables, if any
        joint has gears, hold one value per planet, NaN where a joint has fewer planets than
        another. Raises Diverged at the first recorded time with a value that is not finite, or
        where the solver gave up.
        """
        run, (q, v) = self.scenario, self.start()
        time = recorded_times(run)
        pose, velocity = self.poses.pose(q), self.poses.velocity(q, v)
        states = self.driven_engine.run(pose, velocity, run.steps, run.step_s, run.stride)
        require_finite(self.name, time[: len(states)], states)
        if len(states) < len(time):
            raise Diverged(self.name, float(time[len(states)]))
        pose, velocity = states.swapaxes(0, 1)
        accelerations, energy = np.empty((len(time), states.shape[2])), np.empty(len(time))
        for row, (t, state) in enumerate(zip(time, states, strict=True)):
            accelerations[row] = self.driven_engine.solve(t, *state)[0]
            energy[row] = state[1] @ self.driven_engine.mass_matrix() @ state[1] / 2
        theta, theta_dot, theta_ddot = (
            np.diff(values[:, 2::3][:, self.poses.links], axis=1, prepend=0.0)
            for values in (pose, velocity, accelerations)
        )
        return trajectory(
            self,
            time,
            theta=theta,
            theta_dot=theta_dot,
            theta_ddot=theta_ddot,
            torque=torques_along(self._drive, time, theta, theta_dot),
            **self._mesh_records(time, pose, velocity),
            kinetic_energy=energy,
        )

    def _mesh_records(
        self, time: np.ndarray, pose: np.ndarray, velocity: np.ndarray
    ) -> dict[str, np.ndarray]:
        """The trajectory's mesh variables by name, (times, joints, planets); none without gears."""
        if not self.layout.mesh_joints:
            return {}
        planets = max(len(stage.planets) for stage in self.stages)
        read = np.full((3, 2, len(time), len(self.stages), planets), np.nan)
        for joint, sides in enumerate(self.meshes):
            for side, toothed in enumerate(sides):
                for planet, (mesh, bodies) in enumerate(toothed):
                    seen = [_body_columns(values, bodies) for values in (pose, velocity)]
                    read[:, side, :, joint, planet] = contact.readings(mesh, time, *seen)
        return dict(zip(MESH_VARIABLES, read.reshape(6, *read.shape[2:]), strict=True))


def _body_columns(values: np.ndarray, bodies: Sequence[int]) -> np.ndarray:
    """Columns of a mesh's bodies out of values (times, 3 bodies); zeros for the ground."""
    by_body = values.reshape(len(values), -1, 3)
    columns: list[Any] = [
        np.zeros((len(values), 3)) if body == poses.GROUND else by_body[:, body] for body in bodies
    ]
    return np.concatenate(columns, axis=1)
