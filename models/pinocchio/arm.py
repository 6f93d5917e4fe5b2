"""An arm in Pinocchio: its rigid levels, the first the paper's baseline (Eq. 1), and its gears.

Each is the arm's robot at a level. The rigid levels have runs by DOP853, whose steps adapt.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import Diverged, InputError
from crosscheck.models.experiment.scenario import Scenario, Switches, TableDrive
from crosscheck.models.interface import STATE_ABILITIES, require_finite
from crosscheck.models.pinocchio.robot import PinocchioRobot
from crosscheck.models.robot.arm_model import ArmModel
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


class PinocchioArm(ArmModel):
    """Pinocchio's model of the robot that the arm is."""

    model: PinocchioRobot

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        robot, level = self.find_robot()
        self.model = PinocchioRobot(robot, level, self.switches)


class PinocchioGears(PinocchioArm):
    """The geared arm: links, suns and planets as bodies, pushed by contact forces."""

    name, level = "pinocchio:gears", "geared"


class PinocchioLinks(PinocchioArm):
    """Rigid arm of links and payload only: rods or other bodies with a point mass at the tip.

    Coordinates: joint angles [rad], each relative to the previous link.
    """

    name, level = "pinocchio:links", "links"
    abilities = frozenset({*STATE_ABILITIES, "simulate", "reference"})

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Torques [N m] of the joints, friction overcome, (states, joints), by Newton and Euler."""
        return self.model.inverse_dynamics(q, v, a)

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
        torque = self.driving_torques(time, theta, theta_dot)
        momenta = self.model.mass_matrix(theta) @ theta_dot[:, :, None]
        return trajectory(
            self,
            time,
            theta=theta,
            theta_dot=theta_dot,
            theta_ddot=self.model.forward_dynamics(theta, theta_dot, torque),
            torque=torque,
            kinetic_energy=(theta_dot * momenta[:, :, 0]).sum(axis=1) / 2,
        )

    def _integrate(self, time: np.ndarray, rtol: float) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates (times, n) at the given times [s]. Raises Diverged."""
        from scipy.integrate import solve_ivp  # a third of a second, for runs alone

        state = np.concatenate(self.start())
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
        theta, theta_dot = state[: state.size // 2], state[state.size // 2 :]
        if not np.abs(theta_dot).max() <= FASTEST:  # nor if it is not a number
            raise Diverged(self.name, t)
        return np.concatenate((theta_dot, self.acceleration(t, theta, theta_dot)))


class PinocchioCarriers(PinocchioLinks):
    """Rigid arm of ``links`` and the gears, or motors without gears, as dead weight."""

    name, level = "pinocchio:carriers", "carriers"


class PinocchioArmature(PinocchioLinks):
    """Rigid arm of ``carriers`` and the gears' reflected inertia, as if the previous body stood."""

    name, level = "pinocchio:armature", "armature"


class PinocchioCoupled(PinocchioLinks):
    """Rigid arm with suns and planets that roll: spins couple with the base's rotation."""

    name, level = "pinocchio:coupled", "coupled"
