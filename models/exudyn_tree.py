"""Exudyn model: a kinematic tree of real bodies with a custom mesh-spring connector.

Tree coordinates, in the order of ``_layout``: of every joint the link's angle relative to the
previous link, the sun's relative to the previous link, each planet's relative to its carrier (the
link), all counter-clockwise [rad]. The ring of a joint is part of the previous link, the carrier
of the link. The engine computes the mass matrix, the inertial forces and the motion; the mesh
springs are in ``models.exudyn_mesh``; one connector of the engine holds all of them and the motors,
for a call from the engine into Python takes longer than to work out every mesh.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from numba import njit, typeof

from models.arm import Arm, Joint
from models.drive import DriveData, drive_data, joint_torque
from models.errors import Diverged
from models.exudyn_engine import Body, Engine, UserFunction
from models.exudyn_mesh import (
    Gearing,
    MeshLaw,
    Stage,
    add_meshes,
    base_radius,
    deflection,
    elastic_forces,
    gearing,
    mean_spring,
    mesh_law,
    stiffest,
)
from models.interface import STATE_ABILITIES, Model, gear_coordinates, require_finite
from models.scenario import Scenario, per_joint
from models.switches import Switches
from models.trajectory import recorded_times, trajectory

# [kg] For a body without mass, whose inertia may still count: the engine divides by a body's mass.
# No sum with a number of an arm notices so little.
NO_MASS = 1e-200
# Of the largest acceleration, or squared rate: equal planets differ by the rounding of one linear
# solve, and of centrifugal forces where those are all there is.
PLANETS_AGREE = 1e-9


def _layout(arm: Arm) -> list[Stage]:
    stages, first = [], 0
    for joint in arm.joints:
        after = first + 2 + joint.planet_count
        stages.append(Stage(first, first + 1, tuple(range(first + 2, after))))
        first = after
    return stages


def _composite(parts: Sequence[tuple[float, float, float]]) -> tuple[float, float, float]:
    """Mass, com and inertia about it of rigidly joined parts (mass, x, inertia about own com)."""
    mass, x, inertia = np.array(parts).T
    com = mass @ x / mass.sum()
    return float(mass.sum()), float(com), float(inertia.sum() + mass @ (x - com) ** 2)


def _link_parts(arm: Arm, place: int) -> list[tuple[float, float, float]]:
    """Rod, carrier, and at the far end the next joint's ring or the payload."""
    link, joint = arm.links[place], arm.joints[place]
    rod = link.density_kg_per_m3 * link.cross_section_m2 * link.length_m
    carrier_radius = base_radius(joint, joint.sun_teeth + joint.planet_teeth)
    parts = [
        (rod, link.com_m, rod * link.length_m**2 / 12),
        (joint.carrier_mass_kg, 0.0, joint.carrier_equivalent_mass_kg * carrier_radius**2),
    ]
    if place + 1 < len(arm.joints):
        outer = arm.joints[place + 1]
        return [*parts, (outer.ring_mass_kg, link.length_m, outer.ring_inertia_kg_m2)]
    return [*parts, (arm.payload_mass_kg, link.length_m, 0.0)]


def _bodies(arm: Arm) -> list[Body]:
    """Every body of the arm in the order of the tree coordinates."""
    bodies, parent, axis = [], -1, (0.0, 0.0)
    for place, (stage, joint) in enumerate(zip(_layout(arm), arm.joints, strict=True)):
        sun_radius = base_radius(joint, joint.sun_teeth)
        sun_inertia = joint.sun_equivalent_mass_kg * sun_radius**2
        bodies.append(Body(parent, axis, *_composite(_link_parts(arm, place))))
        bodies.append(Body(parent, axis, joint.sun_mass_kg or NO_MASS, 0.0, sun_inertia))
        bodies += _planets(joint, stage.link)
        parent, axis = stage.link, (arm.links[place].length_m, 0.0)
    return bodies


def _planets(joint: Joint, carrier: int) -> list[Body]:
    radius = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
    inertia = joint.planet_equivalent_mass_kg * base_radius(joint, joint.planet_teeth) ** 2
    angles = 2 * np.pi * np.arange(joint.planet_count) / joint.planet_count
    mass = joint.planet_mass_kg or NO_MASS
    return [
        Body(carrier, (radius * np.cos(a), radius * np.sin(a)), mass, 0.0, inertia) for a in angles
    ]


def tree_from_paper(arm: Arm) -> np.ndarray:
    """A, shape (bodies, 3 joints): tree coordinates of the paper's, all planets of a stage alike.

    From x_sp = r_s (sun - link) + r_p planet and x_pr = -r_r link - r_p planet. The paper's planet
    angle, counted against the carrier, is -(link + planet) here.
    """
    stages = _layout(arm)
    matrix = np.zeros((stages[-1].planets[-1] + 1, 3 * len(stages)))
    for place, (stage, joint) in enumerate(zip(stages, arm.joints, strict=True)):
        sun, planet, ring = _radii(joint)
        columns = slice(3 * place, 3 * place + 3)
        matrix[stage.link, columns] = 0, 0, 1
        matrix[stage.sun, columns] = 1 / sun, 1 / sun, (sun + ring) / sun
        matrix[list(stage.planets), columns] = 0, -1 / planet, -ring / planet
    return matrix


def paper_from_tree(arm: Arm) -> np.ndarray:
    """The way back, shape (3 joints, bodies), with the mean over the planets of a stage."""
    stages = _layout(arm)
    matrix = np.zeros((3 * len(stages), stages[-1].planets[-1] + 1))
    for place, (stage, joint) in enumerate(zip(stages, arm.joints, strict=True)):
        sun, planet, ring = _radii(joint)
        x_sp, x_pr, theta = range(3 * place, 3 * place + 3)
        matrix[x_sp, [stage.sun, stage.link]] = sun, -sun
        matrix[x_sp, list(stage.planets)] = planet / joint.planet_count
        matrix[x_pr, stage.link] = -ring
        matrix[x_pr, list(stage.planets)] = -planet / joint.planet_count
        matrix[theta, stage.link] = 1
    return matrix


def _radii(joint: Joint) -> tuple[float, float, float]:
    """Base radii of sun, planet and ring [m]."""
    sun, planet, ring = (
        base_radius(joint, teeth)
        for teeth in (joint.sun_teeth, joint.planet_teeth, joint.ring_teeth)
    )
    return sun, planet, ring


@njit(cache=True)
def add_motors(
    drive: DriveData,
    ratios: np.ndarray,
    places: np.ndarray,
    t: float,
    q: np.ndarray,
    q_t: np.ndarray,
    forces: np.ndarray,
) -> None:
    """Every motor at time t [s]: T / n on its sun, T from the link's angle and rate."""
    for joint in range(len(places)):
        link, sun = places[joint, 0], places[joint, 1]
        gains, table = drive.gains[joint], drive.table_torque[joint]
        torque = joint_torque(drive.code, gains, drive.table_time, table, t, q[link], q_t[link])
        forces[sun] += torque / ratios[joint]


@njit(cache=True)
def loads_on_tree(
    gears: Gearing,
    drive: DriveData,
    ratios: np.ndarray,
    t: float,
    q: np.ndarray,
    q_t: np.ndarray,
    forces: np.ndarray,
) -> None:
    """All generalized forces [N m] on the tree at time t [s] into ``forces``."""
    forces[:] = 0.0
    add_meshes(gears, t, q, q_t, forces)
    add_motors(drive, ratios, gears.places, t, q, q_t, forces)


def _loads(
    gears: Gearing, drive: DriveData, ratios: np.ndarray, size: int, clock: list[float]
) -> UserFunction:
    """The connector: ``clock[0]`` [s] is added to the engine's time."""
    forces = np.zeros(size)
    add = _entry(loads_on_tree, gears, drive, ratios, 0.0, forces, forces, forces)

    def force(_: object, t: float, _item: int, q: list[float], q_t: list[float]) -> list[float]:
        add(gears, drive, ratios, clock[0] + t, np.array(q), np.array(q_t), forces)
        return forces.tolist()

    return force


def _entry(function: Any, *arguments: object) -> Callable[..., None]:
    """A compiled function for such arguments, past numba's choice among signatures (3 us)."""
    compiled: Callable[..., None] = function.compile(tuple(typeof(a) for a in arguments))
    return compiled


def _ratio(joint: Joint) -> float:
    return joint.ring_teeth / joint.sun_teeth + 1


RIGID = 1e-3  # of the fastest mode: below it an eigenvalue is rounding of the rigid motion


class ExudynTree(Model):
    """The geared arm as a tree of real bodies: links, suns and every single planet.

    Coordinates are the paper's (Eq. 20); a state has all planets of a stage alike. All sums over
    bodies, the inertial forces and the integration (RK44, fixed step) are the engine's.
    """

    name = "exudyn:tree"
    abilities = frozenset({*STATE_ABILITIES, "simulate", "mesh_modes"})

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        self.coordinates = gear_coordinates(len(arm.joints))
        self.stages = _layout(arm)
        self.from_paper = tree_from_paper(arm)
        self.to_paper = paper_from_tree(arm)
        self.laws = [
            (mesh_law(joint, self.switches, "sun"), mesh_law(joint, self.switches, "ring"))
            for joint in arm.joints
        ]

    @cached_property
    def _free(self) -> Engine:
        """The bodies without any force."""
        return Engine(_bodies(self.arm), [], [0.0])

    @cached_property
    def _driven(self) -> Engine:
        """The bodies with meshes and motors."""
        return self._engine(self.laws)

    def _engine(self, laws: Sequence[tuple[MeshLaw, MeshLaw]]) -> Engine:
        bodies, clock = _bodies(self.arm), [0.0]
        drive = drive_data(self.scenario, len(self.stages))
        ratios = np.array([_ratio(joint) for joint in self.arm.joints])
        loads = _loads(gearing(self.stages, laws), drive, ratios, len(bodies), clock)
        return Engine(bodies, [loads], clock)

    def _placed(self, engine: Engine, t: float, q: np.ndarray, v: np.ndarray) -> Engine:
        engine.place(t, self.from_paper @ q, self.from_paper @ v)
        return engine

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M(q), shape (n, n)."""
        mass = self._placed(self._free, 0.0, q, np.zeros_like(q)).mass_matrix()
        return self.from_paper.T @ mass @ self.from_paper

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """C(q, v) v, shape (n,): minus the engine's right-hand side without forces."""
        return -self.from_paper.T @ self._placed(self._free, 0.0, q, v).right_hand_side()

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Drive, mesh and damping force at t [s], shape (n,): what the connectors add."""
        force = self._placed(self._driven, t, q, v).right_hand_side()
        return self.from_paper.T @ force + self.bias(q, v)

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q'' at t [s], shape (n,), of the whole tree.

        Raises ArithmeticError should equal planets not move alike.
        """
        engine = self._placed(self._driven, t, q, v)
        tree = np.linalg.solve(engine.mass_matrix(), engine.right_hand_side())
        paper = self.to_paper @ tree
        size = max(abs(tree).max(), ((self.from_paper @ v) ** 2).max())
        if not np.allclose(self.from_paper @ paper, tree, rtol=0, atol=PLANETS_AGREE * size):
            raise ArithmeticError(f"{self.name}: equal planets do not accelerate alike")
        return paper

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Tree coordinates and rates at t = 0, shape (bodies,) each; no mesh slides."""
        start, joints = self.scenario.start, len(self.arm.joints)
        contact = float(start.mesh == "contact")
        q, v = np.zeros((joints, 3)), np.zeros((joints, 3))
        backlash = [joint.backlash_m for joint in self.arm.joints]
        q[:, 0] = contact * np.array(backlash) + per_joint(start.sun_planet_offset_m, joints)
        q[:, 1] = contact * np.array(backlash) + per_joint(start.planet_ring_offset_m, joints)
        q[:, 2] = per_joint(start.theta_rad, joints)
        v[:, 2] = per_joint(start.theta_dot_rad_per_s, joints)
        return self.from_paper @ q.ravel(), self.from_paper @ v.ravel()

    def simulate(self) -> xr.Dataset:
        """RK44 at the scenario's step, all of it in the engine.

        Mesh variables hold one value per planet, NaN where a stage has fewer planets than another.
        Raises Diverged at the first recorded time with a value that is not finite.
        """
        engine, run = self._driven, self.scenario
        time = recorded_times(run)
        q, v = self.start()
        states = np.empty((len(time), 3, len(q)))
        energy = np.empty(len(time))
        with np.errstate(over="ignore", invalid="ignore"):  # told by require_finite
            for row, t in enumerate(time):
                if row:
                    q, v = self._advanced(engine, t)
                engine.place(t, q, v)
                mass = engine.mass_matrix()
                states[row] = q, v, np.linalg.solve(mass, engine.right_hand_side())
                energy[row] = v @ mass @ v / 2
        require_finite(self.name, time, states, energy)
        return self._trajectory(time, states, energy)

    def _advanced(self, engine: Engine, t: float) -> tuple[np.ndarray, np.ndarray]:
        """The state at the next recorded time, t [s]. Raises Diverged."""
        try:
            return engine.advance(self.scenario.stride, self.scenario.step_s)
        except FloatingPointError:
            raise Diverged(self.name, float(t)) from None

    def _trajectory(self, time: np.ndarray, states: np.ndarray, energy: np.ndarray) -> xr.Dataset:
        q, v, a = states.swapaxes(0, 1)
        links = [stage.link for stage in self.stages]
        theta, theta_dot = q[:, links], v[:, links]
        planets = max(len(stage.planets) for stage in self.stages)
        x = np.full((2, len(time), len(links), planets), np.nan)
        x_dot, force = x.copy(), x.copy()
        for place, (stage, laws) in enumerate(zip(self.stages, self.laws, strict=True)):
            here = slice(len(stage.planets))
            for side, law in enumerate(laws):
                x[side, :, place, here] = deflection(law, stage, q, with_sun=side == 0)
                x_dot[side, :, place, here] = deflection(law, stage, v, with_sun=side == 0)
                force[side, :, place, here] = elastic_forces(
                    law.array, time, x[side, :, place, here], theta[:, place], theta_dot[:, place]
                )
        return trajectory(
            self,
            time,
            theta=theta,
            theta_dot=theta_dot,
            theta_ddot=a[:, links],
            torque=self._torques(time, theta, theta_dot),
            x_sp=x[0],
            x_pr=x[1],
            x_sp_dot=x_dot[0],
            x_pr_dot=x_dot[1],
            F_sp=force[0],
            F_pr=force[1],
            kinetic_energy=energy,
        )

    def _torques(self, time: np.ndarray, theta: np.ndarray, theta_dot: np.ndarray) -> np.ndarray:
        """Output-side torques [N m], shape (times, joints)."""
        law = drive_data(self.scenario, len(self.stages))
        torques = np.empty_like(theta)
        for row, joint in np.ndindex(*theta.shape):
            gains, table = law.gains[joint], law.table_torque[joint]
            angle, rate = float(theta[row, joint]), float(theta_dot[row, joint])
            torques[row, joint] = joint_torque(
                law.code, gains, law.table_time, table, float(time[row]), angle, rate
            )
        return torques

    def largest_stable_step(self) -> float:
        """Largest step [s] of RK44 that lets no mode of the stiffest meshes grow by itself.

        The engine linearises its own tree, all meshes in contact at k_m + k_a, in the start pose.
        """
        return min(_stable_step(mode) for mode in self._eigenvalues(stiffest))

    def mesh_modes(self) -> np.ndarray:
        """Undamped mesh modes [Hz] in the start pose, the planets' own among them, ascending."""
        modes = self._eigenvalues(mean_spring)
        return np.sort(modes.imag[modes.imag > RIGID * modes.imag.max()]) / (2 * np.pi)

    def _eigenvalues(self, linear: Callable[[MeshLaw], MeshLaw]) -> np.ndarray:
        """Eigenvalues [1/s] of the engine's own linearisation in the start pose."""
        engine = self._engine([(linear(sun), linear(ring)) for sun, ring in self.laws])
        q, _ = self.start()
        engine.place(0.0, q, np.zeros_like(q))
        mass, stiffness, damping = engine.linearized()
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
