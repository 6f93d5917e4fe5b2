"""Exudyn model: a kinematic tree of real bodies with a custom mesh-spring connector.

Tree coordinates are those of ``ExudynRobot``: of every joint the link's angle relative to the
previous link, then of each geared one the sun's relative to the previous link and each planet's
relative to its carrier (the link), all counter-clockwise [rad]. The ring of a joint is part of the
previous link, as a direct joint's motor is; the carrier, or the rotor, of the link. The engine
computes the mass matrix, the inertial forces, gravity and the motion; the mesh springs are in
``models.exudyn.tree.mesh``; one user function of the engine's tree holds all of them and motors,
for a call from the engine into Python takes longer than to work out every mesh.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import Diverged
from crosscheck.models.experiment.drive import torques_along
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.exudyn.engine import Engine
from crosscheck.models.exudyn.robot import ExudynRobot
from crosscheck.models.exudyn.tree import mesh
from crosscheck.models.exudyn.tree.laws import bounding_law, mean_spring
from crosscheck.models.exudyn.tree.loads import MotorPlaces, build_load_function, write_tree_loads
from crosscheck.models.exudyn.tree.mesh import MeshLaw, TreeMesh
from crosscheck.models.interface import STATE_ABILITIES, require_finite
from crosscheck.models.robot.arm_model import ArmModel
from crosscheck.models.trajectory import MESH_VARIABLES, recorded_times, trajectory

if TYPE_CHECKING:
    import xarray as xr


class ExudynTree(ArmModel):
    """The geared arm as a tree of real bodies: links, suns and every single planet.

    Coordinates are the paper's (Eq. 20), all planets of a stage alike, or with free planets as many
    as there are bodies. All sums over bodies, the inertial forces and the integration (RK44, fixed
    step) are the engine's.
    """

    name, level = "exudyn:tree", "geared"
    abilities = frozenset({*STATE_ABILITIES, "simulate", "mesh_modes"})
    takes_many_states = False
    model: ExudynRobot

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        self.model = ExudynRobot(*self.find_robot(), self.switches)
        self.from_paper = self.model.rows[:, self.back]

    @cached_property
    def _driven_engine(self) -> Engine:
        """Engine with the bodies, their meshes, motors, friction and gravity."""
        return self._engine(self.model.meshes)

    def _engine(self, meshes: Sequence[TreeMesh]) -> Engine:
        clock, model, joints = [0.0], self.model, range(len(self.arm.joints))
        does_work = self.switches.mesh_work == "conservative"
        teeth = mesh.build_gearing(meshes, does_work, whole=True)
        driven, ratios = zip(*model.motors.values(), strict=True)
        motors = MotorPlaces(np.column_stack([joints, driven]), np.array(ratios))
        data = teeth, self._drive, motors
        force = build_load_function(write_tree_loads, data, len(model.parts), clock)
        return model.build_engine(force, clock)

    def _place_engine(self, t: float, q: np.ndarray, v: np.ndarray) -> Engine:
        self._driven_engine.place(t, self.from_paper @ q, self.from_paper @ v)
        return self._driven_engine

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Generalized force at t [s], shape (n,): drive, meshes, dampers, friction and gravity."""
        force = self._place_engine(t, q, v).right_hand_side()
        return self.from_paper.T @ force + self.bias(q, v)

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q'' at t [s], shape (n,), solved with M."""
        engine = self._place_engine(t, q, v)
        mass = self.from_paper.T @ engine.mass_matrix() @ self.from_paper
        return np.linalg.solve(mass, self.from_paper.T @ engine.right_hand_side())

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Tree coordinates and rates at t = 0, shape (bodies,) each; no mesh slides."""
        q, v = super().start()
        return self.from_paper @ q, self.from_paper @ v

    def simulate(self) -> xr.Dataset:
        """Run the scenario by RK44 at its step, all of it in the engine.

        Mesh variables, if any joint has gears, hold one value per planet, NaN where a joint has
        fewer planets than another.
        Raises Diverged at the first recorded time with a value that is not finite.
        """
        engine, run = self._driven_engine, self.scenario
        time = recorded_times(run)
        q, v = self.start()
        states = np.empty((len(time), 3, len(q)))
        energy = np.empty(len(time))
        with np.errstate(over="ignore", invalid="ignore"):  # reported by require_finite
            for row, t in enumerate(time):
                if row:
                    try:
                        q, v = engine.advance(run.stride, run.step_s)
                    except FloatingPointError:
                        raise Diverged(self.name, float(t)) from None
                engine.place(t, q, v)
                mass = engine.mass_matrix()
                states[row] = q, v, np.linalg.solve(mass, engine.right_hand_side())
                energy[row] = v @ mass @ v / 2
        require_finite(self.name, time, states, energy)
        q, v, a = states.swapaxes(0, 1)
        links = slice(len(self.arm.joints))
        theta, theta_dot = q[:, links], v[:, links]
        return trajectory(
            self,
            time,
            theta=theta,
            theta_dot=theta_dot,
            theta_ddot=a[:, links],
            torque=torques_along(self._drive, time, theta, theta_dot),
            **self._mesh_records(time, q, v),
            kinetic_energy=energy,
        )

    def _mesh_records(
        self, time: np.ndarray, q: np.ndarray, v: np.ndarray
    ) -> dict[str, np.ndarray]:
        """The trajectory's mesh variables by name, (times, joints, planets); none without gears."""
        meshes = self.model.meshes
        if not meshes:
            return {}
        planets = 1 + max(each.number for each in meshes)
        records = np.full((3, 2, len(time), len(self.arm.joints), planets), np.nan)
        read = mesh.read_meshes(mesh.build_gearing(meshes, False, whole=True), time, q, v)
        for row, (_, number, link, wheel, _) in enumerate(meshes):
            records[:, int(wheel == mesh.NO_SUN), :, link, number] = read[:, row]
        return dict(zip(MESH_VARIABLES, records.reshape(6, *records.shape[2:]), strict=True))

    def largest_stable_step(self) -> float:
        """Largest step [s] of RK44 that lets no mode of the stiffest meshes grow by itself.

        The engine linearises its own tree, all meshes in contact at their largest stiffness, in the
        start pose.
        """
        return min(map(_stable_step, self._eigenvalues(bounding_law)))

    def mesh_modes(self) -> np.ndarray:
        """Undamped mesh modes [Hz] in the start pose, ascending: the fastest modes."""
        count = sum(1 + joint.planet_count for joint in self.arm.joints if joint.planet_count)
        modes = self._eigenvalues(mean_spring).imag
        return np.sort(modes)[modes.size - count :] / (2 * np.pi)

    def _eigenvalues(self, linear_law: Callable[[MeshLaw], MeshLaw]) -> np.ndarray:
        """Eigenvalues [1/s] of the engine's own linearisation in the start pose, by such laws."""
        meshes = [each._replace(law=linear_law(each.law)) for each in self.model.meshes]
        engine = self._engine(meshes)
        q, _ = self.start()
        engine.place(0.0, q, np.zeros_like(q))
        mass, stiffness, damping = engine.linearize()
        size = len(mass)
        system = np.block(
            [
                [np.zeros((size, size)), np.eye(size)],
                [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)],
            ]
        )
        return np.linalg.eigvals(system)


def _stable_step(eigenvalue: complex) -> float:
    """Largest h [s] up to which RK4 lets a mode grow no faster than it does in truth."""
    h = np.linspace(0.0, 4 / max(abs(eigenvalue), 1e-300), 40001)  # |R| > 1 all round at |z| = 4
    z = h * eigenvalue
    growth = abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4))))
    grows = growth > np.maximum(1.0, np.exp(z.real)) * (1 + 1e-9)
    return float(h[max(int(np.argmax(grows)) - 1, 0)]) if grows.any() else float("inf")
