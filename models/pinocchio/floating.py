"""The rigid arm of level `coupled` on a free-flying base, in Pinocchio, in the plane.

The base is a homogeneous cube that nothing drives: it moves by the arm's reactions alone. Its
frame sits where the shoulder starts, x along the arm's start direction and out of the face's
middle, so the cube's centre lies half a side behind. Nothing pulls at it: there is no gravity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.interface import STATE_ABILITIES
from crosscheck.models.pinocchio.rigid import PinocchioCoupled
from crosscheck.models.trajectory import recorded_times, trajectory

if TYPE_CHECKING:
    import xarray as xr


# Of DOP853: keeps the momenta of the paper's runs, of order 100 N s and N m s, to 1e-6.
RELATIVE_TOLERANCE = 1e-9
BASE_COORDINATES = ("base_x", "base_y", "base_angle")


@dataclass(frozen=True)
class FloatingBase:
    """A homogeneous cube: mass [kg], side [m]."""

    mass_kg: float
    side_m: float = 2.0

    @property
    def inertia_kg_m2(self) -> float:
        """Inertia about an axis through the centre, parallel to an edge."""
        return self.mass_kg * self.side_m**2 / 6


class PinocchioFloating(PinocchioCoupled):
    """The rigid arm of level `coupled` on a free-flying base, in the plane.

    Coordinates: the base frame's x, y [m] and angle [rad], then the joints', of ``layout``. Raises
    InputError for an arm with gravity.
    """

    name = "pinocchio:floating"
    abilities = frozenset({*STATE_ABILITIES, "simulate"})

    def __init__(self, arm: Arm, scenario: Scenario, base: FloatingBase) -> None:
        gravity = arm.gravity_m_per_s2
        if any(gravity):
            allowed = "must be (0, 0) on a free-flying base"
            raise InputError(arm.name, "gravity_m_per_s2", gravity, allowed)
        self._base = base
        super().__init__(arm, scenario)
        self._friction = np.concatenate((np.zeros(3), self._friction))

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return (*BASE_COORDINATES, *super().coordinates)

    @property
    def arm_mass_kg(self) -> float:
        """Mass of all but the cube: links, payload and the joints' gears, rings included."""
        return float(sum(body.mass for body in self._tree.inertias)) - self._base.mass_kg

    def driving_torques(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Output-side torques [N m] of the motors at time t [s], shape (n,); none on the base."""
        return np.array([0.0, 0.0, 0.0, *super().driving_torques(t, q[3:], v[3:])])

    def simulate(self) -> xr.Dataset:
        """Run the scenario from rest of the base, by DOP853. Raises Diverged.

        Returns theta, theta_dot, theta_ddot, torque, and in the inertial frame: base (time, 3)
        [m, m, rad] and momentum (time, 3) [N s, N s, N m s], angular about the frame's origin.
        """
        time = recorded_times(self.scenario)
        q, v = self._integrate(time, RELATIVE_TOLERANCE)
        states = list(zip(time, q, v, strict=True))
        run = trajectory(
            self,
            time,
            theta=q[:, 3:],
            theta_dot=v[:, 3:],
            theta_ddot=np.array([self.acceleration(*state)[3:] for state in states]),
            torque=np.array([self.driving_torques(*state)[3:] for state in states]),
        )
        momentum = np.array([self.momentum(*state[1:]) for state in states])
        return run.assign(
            base=(("time", "coordinate"), q[:, :3]), momentum=(("time", "component"), momentum)
        )

    def momentum(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Linear x, y [N s] and angular [N m s] momentum about the inertial origin, shape (3,).

        The base's rows of M v are the momenta along its own coordinates: the joints that carry it
        slide along the inertial axes and turn about the base frame's origin.
        """
        push_x, push_y, turn = (self.mass_matrix(q) @ v)[:3]
        return np.array([push_x, push_y, turn + q[0] * push_y - q[1] * push_x])

    def _start(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates (n,) at t = 0: the base is at rest where its frame is inertial."""
        angles, rates = super()._start()
        return np.pad(angles, (3, 0)), np.pad(rates, (3, 0))

    def _build(self) -> pin.Model:
        """Build the tree of the arm on a body that slides along x and y and turns about z."""
        tree = pin.Model()
        tree.gravity.linear = np.zeros(3)
        body = 0
        for name, joint in zip(
            BASE_COORDINATES,
            (pin.JointModelPX(), pin.JointModelPY(), pin.JointModelRZ()),
            strict=True,
        ):
            body = tree.addJoint(body, joint, pin.SE3.Identity(), name)
        cube = pin.Inertia(
            self._base.mass_kg,
            np.array([-self._base.side_m / 2, 0.0, 0.0]),
            np.eye(3) * self._base.inertia_kg_m2,
        )
        tree.appendBodyToJoint(body, cube, pin.SE3.Identity())
        shoulder = pin.Frame("shoulder", body, pin.SE3.Identity(), pin.FrameType.OP_FRAME)
        return pin.appendModel(tree, super()._build(), tree.addFrame(shoulder), pin.SE3.Identity())
