"""MuJoCo as one more gear tree: links, suns and planets are its bodies, pushed at pitch points.

Bodies, inertia, Coriolis forces and lever arms are MuJoCo's; the force of a tooth contact is what
the program offers to guests (crosscheck.models.plugin).
"""

from __future__ import annotations

from math import cos, radians, sin, tau
from typing import Any

import mujoco
import numpy as np

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import MESHES, geared_layout
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.interface import STATE_ABILITIES, Model
from crosscheck.models.plugin import Motors, ToothContact, gear_numbers, link_mass, tooth_contacts
from crosscheck.registry import STATES, Entry

LEAST = 1e-14  # MuJoCo turns no body without mass [kg]


class MujocoGears(Model):
    """M, bias, force and acceleration by MuJoCo, whose angles are relative to the parent body."""

    name = "mujoco:gears"
    abilities = frozenset(STATE_ABILITIES)

    def __init__(self, arm: Arm, scenario: Scenario, chosen: Switches | None = None) -> None:
        super().__init__(arm, scenario, chosen)
        self.layout = geared_layout(arm, self.switches)
        self._motors = Motors(arm, scenario)
        self._model = _tree(arm).compile()
        self._data = mujoco.MjData(self._model)
        self._angle = {self._model.joint(place).name: place for place in range(self._model.nv)}
        self._contacts = tuple(tooth_contacts(arm, self.switches))
        self._to_tree = self._map()
        self._from_tree = np.linalg.pinv(self._to_tree)

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M(q), shape (n, n)."""
        self._stand(q, np.zeros_like(q))
        inertia = np.zeros((self._model.nv, self._model.nv))
        mujoco.mj_fullM(self._model, inertia, self._data.qM)
        return self._to_tree.T @ inertia @ self._to_tree

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal force, shape (n,)."""
        self._stand(q, v)
        return self._to_tree.T @ self._data.qfrc_bias

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Drive, contacts, friction and weight at time t [s], shape (n,)."""
        return self._to_tree.T @ self._forces(t, q, v)

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q'' at time t [s], shape (n,), from the accelerations of all bodies."""
        self._data.qfrc_applied = self._forces(t, q, v)
        self._stand(q, v)
        return self._from_tree @ self._data.qacc

    def _stand(self, q: np.ndarray, v: np.ndarray, gravity: tuple[float, float] = (0, 0)) -> None:
        self._model.opt.gravity = [*gravity, 0]
        self._data.qpos, self._data.qvel = self._to_tree @ q, self._to_tree @ v
        mujoco.mj_forward(self._model, self._data)

    def _forces(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Of weights, motors, friction and tooth contacts on every body's angle [N m]."""
        self._stand(q, np.zeros_like(q), self.arm.gravity_m_per_s2)
        force = -self._data.qfrc_bias
        theta, rate = q[self.layout.theta], v[self.layout.theta]
        motors = self._motors.torques(t, theta, rate)
        for i, joint in enumerate(self.arm.joints):
            force[self._angle[f"sun{i}" if joint.planet_count else f"link{i}"]] += motors[i]
            force[self._angle[f"link{i}"]] -= joint.friction_N_m_s_per_rad * rate[i]
        for contact in self._contacts:
            motion = contact.motion(t, q, v, self.layout)
            force[self._angle[f"link{contact.joint}"]] += contact.torque(motion)
            self._push(contact, contact.force(motion), force)
        return force

    def _push(self, contact: ToothContact, size: float, force: np.ndarray) -> None:
        """Two bodies apart at the pitch point, along the line of action of the touching flanks."""
        i, planet = contact.joint, f"planet{contact.joint}.{contact.planet}"
        joint = self.arm.joints[i]
        teeth, side = (joint.sun_teeth, 1) if contact.with_sun else (joint.ring_teeth, -1)
        central = f"sun{i}" if contact.with_sun else f"link{i - 1}" if i else "world"
        centre, axis = (self._data.body(name).xpos for name in (f"link{i}", planet))
        out = (axis - centre) / np.linalg.norm(axis - centre)
        tangent, alpha = np.array([-out[1], out[0], 0.0]), radians(joint.pressure_angle_deg)
        push = size * cos(alpha) * tangent + side * abs(size) * sin(alpha) * out
        for name, own in ((planet, push), (central, -push)):
            body, point = self._model.body(name).id, centre + teeth * joint.module_m / 2 * out
            mujoco.mj_applyFT(self._model, self._data, own, np.zeros(3), point, body, force)

    def _map(self) -> np.ndarray:
        """Bodies' angles by the coordinates: x is how far the carrier sees teeth come together."""
        tree, unit = np.zeros((self._model.nv, len(self.layout))), np.eye(len(self.layout))
        for i, joint in enumerate(self.arm.joints):
            theta = tree[self._angle[f"link{i}"]] = unit[self.layout.at("theta", i)]
            for p in range(joint.planet_count):
                r_s, r_p, r_r, *_ = gear_numbers(joint)
                x_sp, x_pr = (self.layout.displacement(mesh, i, p) for mesh in MESHES)
                planet = tree[self._angle[f"planet{i}.{p}"]] = -(x_pr + r_r * theta) / r_p
                tree[self._angle[f"sun{i}"]] = (x_sp - r_p * planet) / r_s + theta
        return tree


def _tree(arm: Arm) -> mujoco.MjSpec:
    """Suns and links turn on the previous body, planets on the link; all else is part of these.

    Gears turn about their centres, so their masses may be parts of what holds them; they must be,
    for MuJoCo reckons about the centre of the whole tree, where gears' own inertia would be lost.
    """
    spec = mujoco.MjSpec()
    link, end = spec.worldbody, 0.0
    for i, (joint, rod) in enumerate(zip(arm.joints, arm.links, strict=True)):
        before, at, end = link, (end, 0.0), rod.length_m
        link = _add(before, rod.com_m, *link_mass(rod), f"link{i}", at)
        if isinstance(joint, Planetary):
            gears, count, mass = gear_numbers(joint), joint.planet_count, joint.planet_mass_kg
            _add(before, at[0], joint.ring_mass_kg + joint.sun_mass_kg, joint.ring_inertia_kg_m2)
            _add(link, 0.0, joint.carrier_mass_kg, gears.carrier_inertia)
            _add(link, 0.0, count * mass, count * mass * gears.carrier_radius**2)
            _add(before, 0.0, LEAST, gears.sun_inertia, f"sun{i}", at)
            for p, turn in enumerate(tau * np.arange(count) / count):
                centre = gears.carrier_radius * np.array([cos(turn), sin(turn)])
                _add(link, 0.0, LEAST, gears.planet_inertia, f"planet{i}.{p}", centre)
        else:
            _add(before, at[0], joint.motor_mass_kg, 0.0)
            _add(link, 0.0, 0.0, joint.rotor_inertia_kg_m2)
    _add(link, end, arm.payload_mass_kg, 0.0)
    return spec


def _add(to: Any, x: float, mass: float, inertia: float, name: str = "", at: Any = (0, 0)) -> Any:
    """A body with its mass [kg] and its inertia there [kg m^2] at x [m]; if named, on a hinge."""
    own = {"mass": mass, "inertia": [inertia] * 3, "ipos": [x, 0, 0], "explicitinertial": True}
    body = to.add_body(name=name, pos=[*at, 0], **own)
    if name:
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
    return body


ABOUT = {"call_s": 1e-3, "title": "tooth contacts of crosscheck.models.plugin"}
ENTRY = Entry(__name__, "MujocoGears", "geared", STATES, ("mujoco",), free_planets=True, **ABOUT)
