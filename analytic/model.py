"""The analytic models behind the common interface."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from crosscheck.analytic.derivation.bodies import build_bodies, rigid_bodies
from crosscheck.analytic.derivation.chain import build_exact_chain
from crosscheck.analytic.derivation.gears import Gears, build_gears
from crosscheck.analytic.derivation.terms import Terms, build_chain_terms, inverse_dynamics
from crosscheck.analytic.ensemble import run_alone
from crosscheck.analytic.kernel.adaptive_kernel import integrate_precisely, integrate_reference
from crosscheck.analytic.kernel.batch import Records
from crosscheck.analytic.kernel.equations import KernelEquations, LinkEquations, TermEquations
from crosscheck.analytic.kernel.links import Links, build_links
from crosscheck.analytic.kernel.states import StateEvaluator
from crosscheck.analytic.paper.stiffness import peak_stiffness
from crosscheck.analytic.stability import contact_eigenvalues, runge_kutta_limit
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Layout, geared_layout, rigid_layout
from crosscheck.models.experiment.drive import drive_data
from crosscheck.models.experiment.scenario import (
    Scenario,
    Switches,
    expand_to_joints,
    planet_offsets,
)
from crosscheck.models.interface import STATE_ABILITIES, Model, require_finite
from crosscheck.models.signal_map import SignalMap, map_arm
from crosscheck.models.trajectory import recorded_times, trajectory

if TYPE_CHECKING:
    import xarray as xr


@lru_cache(maxsize=128)
def _build_terms(arm: Arm, layout: Layout, level: str | None) -> Terms:
    """Terms of all bodies of an arm, or of those of a rigid level."""
    chain = build_exact_chain(arm, layout)
    bodies = build_bodies(chain) if level is None else rigid_bodies(chain, level)
    return build_chain_terms(chain, bodies, arm)


class AnalyticModel(Model):
    """Equations of motion from terms, evaluated and run by machine code made for their structure.

    Runs of an arm's own bodies are made over its links, which needs far fewer operations.
    """

    abilities = frozenset((*STATE_ABILITIES, "simulate", "reference", "precise"))
    terms: Terms
    gears: Gears
    links: Links | None = None

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        self.layout = self.find_layout()
        self.drive = drive_data(scenario, len(arm.joints))
        self.gears = build_gears(arm, self.layout, self.switches)

    @abstractmethod
    def find_layout(self) -> Layout:
        """Coordinates of the model, by its arm and switches."""

    @cached_property
    def term_equations(self) -> TermEquations:
        """Equations in the layout's coordinates, from terms."""
        return TermEquations(self.arm, self.layout, self.gears, self.drive, self.terms)

    @cached_property
    def equations(self) -> KernelEquations:
        """Equations that runs are made by: over the links where there are such, else from terms."""
        if self.links is None:
            return self.term_equations
        return LinkEquations(self.arm, self.layout, self.gears, self.drive, self.links)

    @property
    def signal_layout(self) -> Layout:
        """The coordinates that the records of signals belong to."""
        return self.layout

    @cached_property
    def signals(self) -> SignalMap:
        """What the signals are of the kernel's records."""
        return map_arm(self.arm, self.layout)

    @property
    def edges(self) -> np.ndarray:
        """Half clearances (meshes,) [m]."""
        return self.gears.b

    @cached_property
    def states(self) -> StateEvaluator:
        """Evaluator of the equations at single states."""
        return StateEvaluator(self.term_equations)

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """Mass matrix M(q) of Eq. 21, shape (n, n)."""
        return self.states.evaluate(0.0, q, np.zeros_like(q)).mass_matrix

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal force C(q, v) v of Eq. 21, shape (n,)."""
        return self.states.evaluate(0.0, q, v).bias

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Generalized force F - D v of Eqs. 21-22, shape (n,)."""
        return self.states.evaluate(t, q, v).force

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Accelerations q'' of Eq. 21, shape (n,)."""
        return self.states.evaluate(t, q, v).acceleration

    def largest_stable_step(self) -> float:
        """RK4's limit [s] at peak stiffness, over four poses of every joint after the first."""
        stiffness = peak_stiffness(self.gears.law, self.gears.k_m, self.gears.k_a)
        limits = []
        for angle in np.arange(4) * np.pi / 2:
            pose = np.zeros(len(self.layout))
            pose[self.layout.theta] = angle
            poles = contact_eigenvalues(self.terms, self.gears, self.drive, pose, stiffness)
            limits.append(runge_kutta_limit(poles))
        return min(limits)

    def mesh_modes(self) -> np.ndarray:
        """Undamped modes [Hz] in the start pose, ascending: the fastest, of suns and planets."""
        count = int((~self.layout.angular).sum())
        undamped = self.gears._replace(d=np.zeros_like(self.gears.d))
        pose, _ = self.start()
        poles = contact_eigenvalues(self.terms, undamped, self.drive, pose, undamped.k_m)
        return np.sort(poles.imag)[poles.size - count :] / (2 * np.pi)

    def contact_poles(self) -> np.ndarray:
        """Eigenvalues [1/s], (2 n,), linearised about the start pose, every tooth in contact."""
        pose, _ = self.start()
        return contact_eigenvalues(self.terms, self.gears, self.drive, pose, self.gears.k_m)

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """(q, v) of the scenario's start, each of shape (n,)."""
        start, joints = self.scenario.start, len(self.arm.joints)
        q, v = np.zeros((2, len(self.layout)))
        q[self.layout.theta] = expand_to_joints(start.theta_rad, joints)
        v[self.layout.theta] = expand_to_joints(start.theta_dot_rad_per_s, joints)
        for joint in self.layout.mesh_joints:
            self._place_teeth(joint, q)
        return q, v

    def _place_teeth(self, joint: int, q: np.ndarray) -> None:
        """Set the displacements of a joint's meshes at the start in ``q``."""
        start, joints, layout = self.scenario.start, len(self.arm.joints), self.layout
        of_joint = self.gears.theta == layout.theta[joint]
        first = (self.gears.static_error + self.gears.b)[of_joint] * (start.mesh == "contact")
        x_sp, x_pr = first[::2], first[1::2]
        sun = expand_to_joints(start.sun_planet_offset_m, joints)[joint]
        ring = expand_to_joints(start.planet_ring_offset_m, joints)[joint]
        if not layout.free:
            q[layout.at("x_sp", joint)] = x_sp[0] + sun
            q[layout.at("x_pr", joint)] = x_pr[0] + ring
            return
        q[layout.at("x_s", joint)] = (x_sp + x_pr).min() + (sun + ring)
        offsets = planet_offsets(start, joint, self.arm.joints[joint].planet_count)
        for planet, offset in enumerate(offsets):
            q[layout.at("x_pr", joint, planet)] = x_pr[planet] + ring + offset

    def simulate(self) -> xr.Dataset:
        """Run the scenario by fixed-step RK4, as Section 2.4 says."""
        return self.make_trajectory(recorded_times(self.scenario), run_alone(self))

    def precise(self, rtol: float) -> xr.Dataset:
        """Run by an eighth-order method at a relative tolerance, steps ended at contact changes."""
        time = recorded_times(self.scenario)
        records = integrate_precisely(self, rtol).records
        require_finite(self.name, time, *records)
        return self.make_trajectory(time, records)

    def reference(self, rtol: float) -> xr.Dataset:
        """Run by an eighth-order method at a relative tolerance, with the work done on the way.

        Steps run over contacts, and coordinates are the layout's: this shares the method with
        ``precise``, but neither the equations' text nor the search for contacts.
        """
        time = recorded_times(self.scenario)
        run = integrate_reference(self, self.term_equations, rtol)
        require_finite(self.name, time, *run.records)
        work, turned_over = run.works.T
        return self.make_trajectory(time, run.records, work=work, work_turned_over=turned_over)

    def make_trajectory(self, time: np.ndarray, records: Records, **more: np.ndarray) -> xr.Dataset:
        """The trajectory of one run's records, arrays (times, ...), at `time` (times,) [s].

        Lumped, each planet of a joint has the displacements and forces of the one that stands for
        all; NaN beyond a joint's own planets.
        """
        motion = records.q, records.v, records.a
        variables = self.signals.record_run(self.drive, time, motion, records.forces)
        energy = self.equations.kinetic_energy(records.q, records.v)
        return trajectory(self, time, **variables, kinetic_energy=energy, **more)


class BodyModel(AnalyticModel):
    """A model derived from an arm's bodies, from all or those of a rigid level."""

    level: ClassVar[str | None] = None

    @cached_property
    def terms(self) -> Terms:  # type: ignore[override]
        """Terms of these bodies."""
        return _build_terms(self.arm, self.layout, self.level)

    @cached_property
    def links(self) -> Links:  # type: ignore[override]
        """Numbers of the links' equations of these bodies."""
        return build_links(self.arm, self.layout, self.level)


class PhysicalModel(BodyModel):
    """The model of any arm by every body with its true absolute velocity."""

    name = "analytic:physical"
    abilities = AnalyticModel.abilities | {"mesh_modes", "contact_poles"}

    def find_layout(self) -> Layout:
        """Coordinates with planets lumped or free, as the switch says."""
        return geared_layout(self.arm, self.switches)


class RigidModel(BodyModel):
    """Eq. 1: the arm with rigid joints, at one of the levels of analytic.derivation.bodies."""

    def find_layout(self) -> Layout:
        """The joints' angles alone."""
        return rigid_layout(self.arm)

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Torques [N m] on the output side that give accelerations a at q, v: (states, joints)."""
        return inverse_dynamics(self.terms, q, v, a)


class RigidLinks(RigidModel):
    """The rigid arm of links and payload only."""

    name, level = "analytic:links", "links"


class RigidCarriers(RigidModel):
    """The rigid arm with joint masses and carriers."""

    name, level = "analytic:carriers", "carriers"


class RigidArmature(RigidModel):
    """The rigid arm with the gears' reflected inertia on the diagonal of M."""

    name, level = "analytic:armature", "armature"


class RigidCoupled(RigidModel):
    """The rigid arm with the coupling of rotor spin and base rotation."""

    name, level = "analytic:coupled", "coupled"
