"""Exudyn model: a kinematic tree of real bodies with a custom mesh-spring connector.

Tree coordinates, in the order of ``build_stages``: of every joint the link's angle relative to the
previous link, and of a geared one the sun's relative to the previous link and each planet's
relative to its carrier (the link), all counter-clockwise [rad]. The ring of a joint is part of the
previous link, as a direct joint's motor is; the carrier, or the rotor, of the link. The engine
computes the mass matrix, the inertial forces, gravity and the motion; the mesh springs are in
``models.exudyn.tree.mesh``; one user function of the engine's tree holds all of them, motors and
friction, for a call from the engine into Python takes longer than to work out every mesh.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.errors import Diverged
from crosscheck.models.experiment.drive import torques_along
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.exudyn.engine import Engine
from crosscheck.models.exudyn.tree import mesh, parts
from crosscheck.models.exudyn.tree.laws import bounding_law, build_gear_stage, mean_spring
from crosscheck.models.exudyn.tree.loads import build_joints, build_load_function
from crosscheck.models.exudyn.tree.mesh import GearStage, MeshLaw
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

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        self.stages = parts.build_stages(arm)
        self.from_paper = parts.tree_from_paper(arm, self.layout)
        self.bodies = parts.build_bodies(arm, self.find_robot()[0])
        self.gears = [
            build_gear_stage(place, stage, joint, self.switches)
            for place, (stage, joint) in enumerate(zip(self.stages, arm.joints, strict=True))
            if isinstance(joint, Planetary)
        ]

    @cached_property
    def _free_engine(self) -> Engine:
        """An engine that holds the bodies and no force."""
        return Engine(self.bodies, None, [0.0], gravity=(0.0, 0.0))

    @cached_property
    def _driven_engine(self) -> Engine:
        """Engine with the bodies, their meshes, motors, friction and gravity."""
        return self._engine(self.gears)

    def _engine(self, gears: Sequence[GearStage]) -> Engine:
        clock = [0.0]
        joints = build_joints(self.arm, self.stages)
        teeth = mesh.build_gearing(gears, self.switches.mesh_work == "conservative")
        force = build_load_function(teeth, self._drive, joints, len(self.bodies), clock)
        return Engine(self.bodies, force, clock, self.arm.gravity_m_per_s2)

    def _place_engine(self, engine: Engine, t: float, q: np.ndarray, v: np.ndarray) -> Engine:
        engine.place(t, self.from_paper @ q, self.from_paper @ v)
        return engine

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M(q), shape (n, n)."""
        mass = self._place_engine(self._free_engine, 0.0, q, np.zeros_like(q)).mass_matrix()
        return self.from_paper.T @ mass @ self.from_paper

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """C(q, v) v, shape (n,): minus the engine's right-hand side without forces."""
        return (
            -self.from_paper.T @ self._place_engine(self._free_engine, 0.0, q, v).right_hand_side()
        )

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Generalized force at t [s], shape (n,): drive, meshes, dampers, friction and gravity."""
        force = self._place_engine(self._driven_engine, t, q, v).right_hand_side()
        return self.from_paper.T @ force + self.bias(q, v)

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q'' at t [s], shape (n,), solved with M."""
        engine = self._place_engine(self._driven_engine, t, q, v)
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
        links = [stage.link for stage in self.stages]
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
        if not self.gears:
            return {}
        planets = max(len(stage.planets) for stage in self.stages)
        records = np.full((3, 2, len(time), len(self.stages), planets), np.nan)
        x, x_dot, force = records
        for gear in self.gears:
            stage, link = gear.bodies, gear.bodies.link
            for side, planet in np.ndindex(2, len(stage.planets)):
                law = (gear.sun, gear.ring)[side][planet]
                at = side, slice(None), gear.joint, planet
                x[at] = mesh.deflection(law, stage, planet, q, with_sun=side == 0)
                x_dot[at] = mesh.deflection(law, stage, planet, v, with_sun=side == 0)
                force[at] = mesh.elastic_forces(law.array, time, x[at], q[:, link], v[:, link])
        return dict(zip(MESH_VARIABLES, records.reshape(6, *x.shape[1:]), strict=True))

    def largest_stable_step(self) -> float:
        """Largest step [s] of RK44 that lets no mode of the stiffest meshes grow by itself.

        The engine linearises its own tree, all meshes in contact at their largest stiffness, in the
        start pose.
        """
        return min(
            _stable_step(mode)
            for mode in self._eigenvalues(_linear_stages(self.gears, bounding_law))
        )

    def mesh_modes(self) -> np.ndarray:
        """Undamped mesh modes [Hz] in the start pose, ascending: the fastest modes."""
        count = sum(1 + joint.planet_count for joint in self.arm.joints if joint.planet_count)
        modes = self._eigenvalues(_linear_stages(self.gears, mean_spring)).imag
        return np.sort(modes)[modes.size - count :] / (2 * np.pi)

    def _eigenvalues(self, gears: Sequence[GearStage]) -> np.ndarray:
        """Eigenvalues [1/s] of the engine's own linearisation in the start pose."""
        engine = self._engine(gears)
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


def _linear_stages(
    gears: Sequence[GearStage], law: Callable[[MeshLaw], MeshLaw]
) -> list[GearStage]:
    return [
        gear._replace(sun=tuple(map(law, gear.sun)), ring=tuple(map(law, gear.ring)))
        for gear in gears
    ]


def _stable_step(eigenvalue: complex) -> float:
    """Largest h [s] up to which RK4 lets a mode grow no faster than it does in truth."""
    h = np.linspace(0.0, 4 / max(abs(eigenvalue), 1e-300), 40001)  # |R| > 1 all round at |z| = 4
    z = h * eigenvalue
    growth = abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4))))
    grows = growth > np.maximum(1.0, np.exp(z.real)) * (1 + 1e-9)
    return float(h[max(int(np.argmax(grows)) - 1, 0)]) if grows.any() else float("inf")
