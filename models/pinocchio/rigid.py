"""The rigid arm in Pinocchio: the paper's baseline (Eq. 1) and three steps towards its gears.

Each level is a kinematic tree of bodies in the plane, frames at the joints, z the joint axis, x
along the link. What each level adds is stated by its class; no formula of the arm's dynamics stands
here, Pinocchio works them out. Gears turn by pure rolling and without backlash; only the joints
have friction. Motors of joints without gears are dead weight, from the second level on.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from crosscheck.models.arm.arm import Arm, Direct, Planetary
from crosscheck.models.arm.layout import rigid_layout
from crosscheck.models.errors import Diverged, InputError
from crosscheck.models.experiment.drive import drive_data, joint_torque
from crosscheck.models.experiment.scenario import Scenario, Switches, TableDrive, expand_to_joints
from crosscheck.models.interface import STATE_ABILITIES, Model, require_finite
from crosscheck.models.pinocchio import tree as parts
from crosscheck.models.trajectory import recorded_times, trajectory

if TYPE_CHECKING:
    import xarray as xr


# Of DOP853. Inside its steps, which can be 10 ms long, recorded states are interpolated at a lower
# order: in the 0.5 s runs of the paper's arm 1e-13 keeps 2e-13 rad and 3e-12 rad/s on the whole
# grid and 2e-14 rad at the end; 1e-12 leaves 2e-13 rad at the end, and a twelfth digit turns.
RELATIVE_TOLERANCE = 1e-13
# Absolute over relative tolerance [rad, rad/s]: angles under 1e-3 rad count as small. Values from 1
# to 1e-8 all leave errors of the same size in those runs: the arm is at rest for one instant only.
SMALL = 1e-3
# [rad/s] No arm turns so fast; a run away grows exponentially, while its steps shrink as fast.
FASTEST = 1e5
# Of the equations of motion in one run, about a minute: the paper's arm under constant torque takes
# one million for 20 s, under a drive of 1e6 rad/s thirty million for every second.
MOST_EVALUATIONS = 3_000_000


class PinocchioLinks(Model):
    """Rigid arm of links and payload only: rods or other bodies with a point mass at the tip.

    Coordinates: joint angles [rad], each relative to the previous link.
    """

    name = "pinocchio:links"
    abilities = frozenset({*STATE_ABILITIES, "simulate", "reference"})

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        self.layout = rigid_layout(arm)
        self._drive = drive_data(scenario, len(arm.joints))
        self._friction = np.array([joint.friction_N_m_s_per_rad for joint in arm.joints])
        self._weightless = self._build()
        self._tree = self._weightless.copy()
        self._tree.gravity.linear = np.array([*arm.gravity_m_per_s2, 0.0])
        self._data = self._tree.createData()
        if not self._tree.check(self._data):
            raise RuntimeError(f"{self.name}: joints of the tree are not in depth-first order")

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M(q) [kg m^2], shape (n, n), by the composite rigid body algorithm."""
        return np.array(pin.crba(self._tree, self._data, q))

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal torque [N m], shape (n,), by recursive Newton-Euler."""
        return np.array(pin.nle(self._weightless, self._data, q, v))

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Drive, friction and gravity [N m] at time t [s], shape (n,)."""
        still = np.zeros_like(v)
        # At rest, the joints must hold the weights.
        return self._joint_torques(t, q, v) - pin.rnea(self._tree, self._data, q, still, still)

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """theta'' [rad/s^2] at time t [s], shape (n,), by the articulated body algorithm."""
        return np.array(pin.aba(self._tree, self._data, q, v, self._joint_torques(t, q, v)))

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Torques [N m] of the joints, friction overcome, (states, joints), by Newton and Euler."""
        tree, data, solve = self._tree, self._data, pin.rnea
        torques = [solve(tree, data, *state) for state in zip(q, v, a, strict=True)]
        return np.array(torques).reshape(q.shape) + self._friction * v

    def driving_torques(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Output-side torques [N m] of the motors at time t [s], shape (n,)."""
        law, gains, table_time, table_torque = self._drive
        return np.array(
            [
                joint_torque(law, gains[i], table_time, table_torque[i], t, q[i], v[i])
                for i in range(len(gains))
            ]
        )

    def simulate(self) -> xr.Dataset:
        """Run the scenario from its start by DOP853, recorded on the scenario's grid.

        Returns theta, theta_dot, theta_ddot, torque and kinetic_energy. Raises Diverged.
        """
        return self.reference(RELATIVE_TOLERANCE)

    def reference(self, rtol: float) -> xr.Dataset:
        """``simulate`` at another relative tolerance, at least 2.3e-14. Raises Diverged."""
        scenario = self.scenario
        time = recorded_times(scenario)
        theta, theta_dot = self._integrate(time, rtol)
        states = list(zip(time, theta, theta_dot, strict=True))
        return trajectory(
            self,
            time,
            theta=theta,
            theta_dot=theta_dot,
            theta_ddot=np.array([self.acceleration(*state) for state in states]),
            torque=np.array([self.driving_torques(*state) for state in states]),
            kinetic_energy=np.array([0.5 * v @ self.mass_matrix(q) @ v for _, q, v in states]),
        )

    def _build(self) -> pin.Model:
        """The tree; each level adds its bodies to that of the level below."""
        return parts.build_links(self.arm)

    def _joint_torques(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Torques in the joints [N m], drive and friction, shape (n,)."""
        return self.driving_torques(t, q, v) - self._friction * v

    def _start(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates (n,) at t = 0."""
        start, joints = self.scenario.start, len(self.arm.joints)
        angles, rates = start.theta_rad, start.theta_dot_rad_per_s
        return np.array(expand_to_joints(angles, joints)), np.array(expand_to_joints(rates, joints))

    def _integrate(self, time: np.ndarray, rtol: float) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates (times, n) at the given times [s]. Raises Diverged."""
        from scipy.integrate import solve_ivp  # a third of a second, for runs alone

        state = np.concatenate(self._start())
        states = np.empty((len(time), len(state)))
        self._evaluations = 0
        for begin, end in pairwise(self._smooth_pieces(time[-1])):
            run = solve_ivp(
                self._rate,
                (begin, end),
                state,
                method="DOP853",
                dense_output=True,
                rtol=rtol,
                atol=SMALL * rtol,
            )
            if not run.success:
                raise Diverged(self.name, float(run.t[-1]))
            inside = (begin <= time) & (time <= end)
            states[inside] = run.sol(time[inside]).T
            state = run.y[:, -1]
        require_finite(self.name, time, states)
        q, v = np.split(states, 2, axis=1)
        return q, v

    def _smooth_pieces(self, end: float) -> np.ndarray:
        """Times between which the drive is smooth: a step might leap over a short pulse.

        The square root of time is singular at 0 alone, where step control starts small enough:
        theta grows as t^(5/2), and the first 0.1 s of the back-and-forth run keep 1e-13 rad.
        """
        drive = self.scenario.drive
        kinks = np.array(drive.time_s if isinstance(drive, TableDrive) else ())
        return np.array([0.0, *kinks[(kinks > 0) & (kinks < end)], end])

    def _rate(self, t: float, state: np.ndarray) -> np.ndarray:
        """Derivative d(theta, theta')/dt of a state, shape (2 n,).

        Raises Diverged where step control would never come to an end, InputError where it would
        not within MOST_EVALUATIONS.
        """
        self._evaluations += 1
        if self._evaluations > MOST_EVALUATIONS:
            allowed = f"{self.name} came to t = {t:.3g} s in {MOST_EVALUATIONS:,} evaluations"
            where = self.scenario.name
            raise InputError(where, "duration_s", self.scenario.duration_s, f"{allowed}, the most")
        theta, theta_dot = np.split(state, 2)
        if not np.abs(theta_dot).max() < FASTEST:  # nor if it is not a number
            raise Diverged(self.name, t)
        return np.concatenate((theta_dot, self.acceleration(t, theta, theta_dot)))


class PinocchioCarriers(PinocchioLinks):
    """Rigid arm of ``links`` and the gears as dead weight: joint masses, carriers, planets' orbits.

    The joint mass m_s + N m_p + m_c + m_r sits at the end of the previous link (on the base for the
    first joint), I_c + N m_p r_c^2 turns with the carrier's link, the ring with the previous link.
    Without gears it is the motor's mass that sits there, and its rotor that turns with the link.
    """

    name = "pinocchio:carriers"

    def _build(self) -> pin.Model:
        tree = super()._build()
        for number, joint in enumerate(self.arm.joints, 1):
            if isinstance(joint, Direct):
                parts.attach_motor(tree, number, joint)
                continue
            orbit = joint.planet_count * joint.planet_mass_kg * parts.carrier_radius(joint) ** 2
            parts.attach(tree, number, 0.0, parts.carrier_inertia(joint) + orbit)
            parts.attach_to_previous(tree, number, _joint_mass(joint), joint.ring_inertia_kg_m2)
        return tree


class PinocchioArmature(PinocchioCarriers):
    """Rigid arm of ``carriers`` and the gears' reflected inertia, as if the previous body stood."""

    name = "pinocchio:armature"

    def _build(self) -> pin.Model:
        tree = super()._build()
        tree.armature = np.array(
            [
                # Without gears the rotor has the link's rate.
                0.0 if isinstance(joint, Direct) else parts.reflected_inertia(joint)
                for joint in self.arm.joints
            ]
        )
        return tree


class PinocchioCoupled(PinocchioLinks):
    """Rigid arm with suns and planets on mimic joints: spins couple with the base's rotation."""

    name = "pinocchio:coupled"

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """theta'' [rad/s^2] at time t [s], shape (n,); aba does not know mimic joints."""
        resisting = pin.nle(self._tree, self._data, q, v)  # velocities and weights
        return np.linalg.solve(self.mass_matrix(q), self._joint_torques(t, q, v) - resisting)

    def _build(self) -> pin.Model:
        tree, stages = parts.build_tree(self.arm)
        for stage, joint in zip(stages, self.arm.joints, strict=True):
            if isinstance(joint, Direct):
                continue
            turns = dict.fromkeys(stage.planets, parts.planet_turns(joint))
            for body, ratio in (turns | {stage.driven: parts.sun_turns(joint)}).items():
                tree = pin.transformJointIntoMimic(tree, stage.link, body, ratio, 0.0)
        return tree


def _joint_mass(joint: Planetary) -> float:
    """The paper's m_j [kg]: mass of sun, planets, carrier and ring."""
    planets = joint.planet_count * joint.planet_mass_kg
    return joint.sun_mass_kg + planets + joint.carrier_mass_kg + joint.ring_mass_kg
