"""The analytic models behind the common interface."""

from __future__ import annotations

from functools import lru_cache
from typing import ClassVar

import numpy as np
import sympy as sp
import xarray as xr

from analytic import kernel
from analytic.energies import energies_form
from analytic.gears import Gears, gears, no_gears
from analytic.lagrange import Form
from analytic.physical import physical_form
from analytic.printed import printed_form
from analytic.recording import along
from analytic.reference import solve
from analytic.rigid import rigid_form
from analytic.stability import contact_eigenvalues, runge_kutta_limit
from analytic.symbols import Variables, geared_variables, parameter_values, rigid_variables
from analytic.terms import Terms, numeric_terms
from models.arm import Arm
from models.drive import drive_data
from models.errors import InputError
from models.interface import (
    STATE_ABILITIES,
    Model,
    gear_coordinates,
    link_coordinates,
    require_finite,
)
from models.scenario import Scenario, per_joint
from models.switches import Switches
from models.trajectory import recorded_times, trajectory

RIGID = 1e-3  # of the fastest mode: below it an eigenvalue is rounding of the rigid motion


def _terms(form: Form, arm: Arm, variables: Variables) -> Terms:
    return _terms_for(form, variables, tuple(parameter_values(arm).items()))


@lru_cache(maxsize=128)  # arms of equal masses and radii share their terms, whatever the teeth do
def _terms_for(
    form: Form, variables: Variables, values: tuple[tuple[sp.Symbol, float], ...]
) -> Terms:
    return numeric_terms(form, dict(values), variables.mesh_forces, variables.torques)


class AnalyticModel(Model):
    """Equations of motion from a symbolic form, evaluated by the compiled kernel."""

    abilities = frozenset((*STATE_ABILITIES, "simulate", "reference"))
    terms: Terms
    gears: Gears

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        self.drive = drive_data(scenario, len(arm.joints))

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M(q) of Eq. 21."""
        out = np.empty((q.size, q.size))
        kernel.mass_matrix(self.terms, q, out)
        return out

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """C(q, v) v of Eq. 21."""
        out = np.empty_like(q)
        kernel.bias(self.terms, q, v, out)
        return out

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """F - D v of Eqs. 21-22."""
        out = np.empty_like(q)
        kernel.generalized_force(self.terms, self.gears, self.drive, t, q, v, out)
        return out

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q'' of Eq. 21."""
        out = np.empty_like(q)
        kernel.acceleration(self.terms, self.gears, self.drive, t, q, v, out)
        return out

    def largest_stable_step(self) -> float:
        """RK4's limit [s] at peak stiffness, over four poses of every joint after the first."""
        stiffness = self.gears.k_m + self.gears.k_a
        limits = []
        for angle in np.arange(4) * np.pi / 2:
            pose = np.zeros(len(self.coordinates))
            pose[self._theta] = angle
            poles = contact_eigenvalues(self.terms, self.gears, self.drive, pose, stiffness)
            limits.append(runge_kutta_limit(poles))
        return min(limits)

    def mesh_modes(self) -> np.ndarray:
        """Undamped modes [Hz] in the start pose, ascending."""
        undamped = self.gears._replace(d=np.zeros_like(self.gears.d))
        pose, _ = self.start()
        poles = contact_eigenvalues(self.terms, undamped, self.drive, pose, undamped.k_m)
        return np.sort(poles.imag[poles.imag > RIGID * poles.imag.max()]) / (2 * np.pi)

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """(q, v) of the scenario's start, each of shape (n,)."""
        start, joints = self.scenario.start, len(self.arm.joints)
        q, v = np.zeros(len(self.coordinates)), np.zeros(len(self.coordinates))
        q[self._theta] = per_joint(start.theta_rad, joints)
        v[self._theta] = per_joint(start.theta_dot_rad_per_s, joints)
        if self.gears.where.size:
            if start.mesh == "contact":
                q[self.gears.where] = self.gears.b
            q[self.gears.where[::2]] += per_joint(start.sun_planet_offset_m, joints)
            q[self.gears.where[1::2]] += per_joint(start.planet_ring_offset_m, joints)
        return q, v

    def simulate(self) -> xr.Dataset:
        """Fixed-step RK4, as Section 2.4 says."""
        scenario = self.scenario
        q, v = self.start()
        qs, vs = kernel.integrate(
            self.terms,
            self.gears,
            self.drive,
            q,
            v,
            scenario.step_s,
            scenario.steps,
            scenario.stride,
        )
        time = recorded_times(scenario)
        require_finite(self.name, time, qs, vs)
        return self.record(time, qs, vs)

    def reference(self, rtol: float) -> xr.Dataset:
        """SciPy's DOP853 on the recording grid, with the work done along the way."""
        scenario = self.scenario
        grid = recorded_times(scenario)
        qs, vs, work = solve(self.terms, self.gears, self.drive, self.start(), grid, rtol)
        require_finite(self.name, grid, qs, vs)
        return self.record(grid, qs, vs, work=work[:, 0], work_turned_over=work[:, 1])

    def record(
        self, time: np.ndarray, qs: np.ndarray, vs: np.ndarray, **more: np.ndarray
    ) -> xr.Dataset:
        """The trajectory through states qs, vs of shape (times, n) at `time` (times,) [s]."""
        accelerations, forces, torques, energy = along(
            self.terms, self.gears, self.drive, time, qs, vs
        )
        variables = {
            "theta": qs[:, self._theta],
            "theta_dot": vs[:, self._theta],
            "theta_ddot": accelerations[:, self._theta],
            "torque": torques,
            "kinetic_energy": energy,
            **more,
        }
        if self.gears.where.size:
            for offset, mesh in enumerate(("sp", "pr")):
                where = self.gears.where[offset::2]
                variables[f"x_{mesh}"] = self._per_planet(qs[:, where])
                variables[f"x_{mesh}_dot"] = self._per_planet(vs[:, where])
                variables[f"F_{mesh}"] = self._per_planet(forces[:, offset::2])
        return trajectory(self, time, **variables)

    @property
    def _theta(self) -> np.ndarray:
        """Where the joint angles are among the coordinates."""
        per = len(self.coordinates) // len(self.arm.joints)
        return np.arange(per - 1, len(self.coordinates), per)

    def _per_planet(self, values: np.ndarray) -> np.ndarray:
        """The lumped value, repeated for each planet; NaN beyond a joint's own planets."""
        planets = [joint.planet_count for joint in self.arm.joints]
        repeated = np.repeat(values[:, :, None], max(planets), axis=2)
        for joint, count in enumerate(planets):
            repeated[:, joint, count:] = np.nan
        return repeated


class FormModel(AnalyticModel):
    """A geared arm in the paper's coordinates, with any symbolic form of its equations."""

    name = "analytic:form"
    abilities = AnalyticModel.abilities | {"mesh_modes"}

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None, form: Form
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        self.coordinates = gear_coordinates(len(arm.joints))
        self.gears = gears(arm, self.switches)
        self.terms = _terms(form, arm, geared_variables(len(arm.joints)))


class PhysicalModel(FormModel):
    """True absolute velocities of all bodies."""

    name = "analytic:physical"

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches, physical_form(len(arm.joints)))


class PaperModel(FormModel):
    """A form that the paper writes for two joints with three planets each.

    Raises InputError for any other arm.
    """

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None, form: Form
    ) -> None:
        planets = [joint.planet_count for joint in arm.joints]
        if planets != [3, 3]:
            allowed = f"analytic:{form.name} needs two joints with three planets each"
            raise InputError(arm.name, "joints", None, allowed)
        super().__init__(arm, scenario, chosen_switches, form)


class PrintedModel(PaperModel):
    """Eqs. 21-22 entry for entry."""

    name = "analytic:printed"

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches, printed_form())


class EnergiesModel(PaperModel):
    """Eqs. 16-19 through Lagrange's equations."""

    name = "analytic:energies"

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches, energies_form())


class RigidModel(AnalyticModel):
    """Eq. 1: the arm with rigid joints, at one of the levels of analytic.rigid."""

    level: ClassVar[str]

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, chosen_switches)
        joints = len(arm.joints)
        self.coordinates = link_coordinates(joints)
        self.gears = no_gears()
        self.terms = _terms(rigid_form(joints, self.level), arm, rigid_variables(joints))


class RigidLinks(RigidModel):
    """Links and payload only."""

    name, level = "analytic:links", "links"


class RigidCarriers(RigidModel):
    """With joint masses and carriers."""

    name, level = "analytic:carriers", "carriers"


class RigidArmature(RigidModel):
    """With the gears' reflected inertia on the diagonal."""

    name, level = "analytic:armature", "armature"


class RigidCoupled(RigidModel):
    """With the coupling of rotor spin and base rotation."""

    name, level = "analytic:coupled", "coupled"
