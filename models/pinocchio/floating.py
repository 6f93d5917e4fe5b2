"""The rigid arm of level `coupled` on a free-flying base, in Pinocchio, in the plane.

The base is a homogeneous cube that nothing drives: it moves by the arm's reactions alone. Its
frame sits where the shoulder starts, x along the arm's start direction and out of the face's
middle, so the cube's centre lies half a side behind. Nothing pulls at it: there is no gravity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.interface import STATE_ABILITIES
from crosscheck.models.pinocchio.arm import PinocchioCoupled
from crosscheck.models.robot.file import build_robot
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.models.trajectory import recorded_times, trajectory

if TYPE_CHECKING:
    import xarray as xr


# Of DOP853: keeps the momenta of the paper's runs, of order 100 N s and N m s, to 1e-6.
RELATIVE_TOLERANCE = 1e-9
BASE_COORDINATES = ("base_x", "base_y", "base_angle")
# Two slides and a pin that carry an arm's base, and the cube on it: mass, centre along x, inertia.
FLOATING_BASE = """\
<link name="ground"/><link name="slide_x"/><link name="slide_y"/>
<joint name="base_x" type="prismatic"><parent link="ground"/><child link="slide_x"/>
  <axis xyz="1 0 0"/><limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/></joint>
<joint name="base_y" type="prismatic"><parent link="slide_x"/><child link="slide_y"/>
  <axis xyz="0 1 0"/><limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/></joint>
<joint name="base_angle" type="continuous"><parent link="slide_y"/><child link="base"/>
  <axis xyz="0 0 1"/></joint>
<joint name="to_cube" type="fixed"><parent link="base"/><child link="cube"/></joint>
<link name="cube"><inertial><origin xyz="{1!r} 0 0"/><mass value="{0!r}"/>
  <inertia ixx="{2!r}" ixy="0" ixz="0" iyy="{2!r}" iyz="0" izz="{2!r}"/></inertial></link>
</robot>"""


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
        self.order = self._back = np.arange(len(self.coordinates))

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return (*BASE_COORDINATES, *super().coordinates)

    @property
    def arm_mass_kg(self) -> float:
        """Mass of all but the cube: links, payload and the joints' gears, rings included."""
        return float(sum(body.mass for body in self.model.robot.bodies)) - self._base.mass_kg

    def find_robot(self) -> tuple[Robot, Level]:
        """The robot that the arm is, its base on two slides and a pin. Raises InputError."""
        robot, level = super().find_robot()
        cube = self._base
        base = FLOATING_BASE.format(cube.mass_kg, -cube.side_m / 2, cube.inertia_kg_m2)
        urdf = robot.urdf.replace("</robot>", base)
        return build_robot(robot.content, urdf, robot.name, robot.name, is_bounded=False), level

    def driving_torques(self, time: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Output-side torques (states, n) [N m] of the motors; none on the base."""
        return np.pad(super().driving_torques(time, q[:, 3:], v[:, 3:]), ((0, 0), (3, 0)))

    def simulate(self) -> xr.Dataset:
        """Run the scenario from rest of the base, by DOP853. Raises Diverged.

        Returns theta, theta_dot, theta_ddot, torque, and in the inertial frame: base (time, 3)
        [m, m, rad] and momentum (time, 3) [N s, N s, N m s], angular about the frame's origin.
        """
        time = recorded_times(self.scenario)
        q, v = self._integrate(time, RELATIVE_TOLERANCE)
        torque = self.driving_torques(time, q, v)
        run = trajectory(
            self,
            time,
            theta=q[:, 3:],
            theta_dot=v[:, 3:],
            theta_ddot=self.model.forward_dynamics(q, v, torque)[:, 3:],
            torque=torque[:, 3:],
        )
        # Linear along x and y, angular about z.
        momentum = self.model.momentum(q, v)[:, [0, 1, 5]]
        return run.assign(
            base=(("time", "coordinate"), q[:, :3]), momentum=(("time", "component"), momentum)
        )

    def _start(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates (n,) at t = 0: the base is at rest where its frame is inertial."""
        angles, rates = super()._start()
        return np.pad(angles, (3, 0)), np.pad(rates, (3, 0))
