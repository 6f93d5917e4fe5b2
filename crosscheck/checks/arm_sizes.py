"""How large an arm's quantities are at its states: what differences are parts of.

Inertia, weight, drive and teeth give the sizes, no model that is compared: so none makes room for
its own errors, and a component that vanishes at some states has a size like any other.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.checks.first_principles import composite
from crosscheck.checks.robot_states import SIZE_WORDS
from crosscheck.checks.scales import (
    EPS,
    PLACE_ROUNDINGS,
    SLIDING_M_PER_S,
    ReasonedLimit,
    arm_reach,
    gear_arc,
    geared_joints,
    largest_displacement,
    largest_weights,
    mesh_damping,
    meshes,
    motor_forces,
    stiffness_bound,
)
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import MESHES, Layout
from crosscheck.models.experiment.drive import drive_data, torques_along
from crosscheck.models.loading import Case

if TYPE_CHECKING:
    from crosscheck.checks.answers import States

# Roundings of a natural size by which models may differ. On 800 random arms of up to seven joints
# those of the program leave 33 in M and 20 in the rest; MuJoCo, which has levers of all bodies from
# their places on the ground, 46 and 7.
ROUNDINGS, ROUNDINGS_OF_M = 50, 200
# Quantities with forces of teeth, whose displacements are small differences of large arcs.
OF_TEETH = ("generalized_force", "corner_force", "acceleration")
FORCE = "torques, largest weight and friction of a joint; teeth at the largest displacement"
WORDS = SIZE_WORDS | dict.fromkeys(("generalized_force", "corner_force"), FORCE)
WORDS["acceleration"] = "|M^-1| times force, bias and |M| |a|"


@dataclass(frozen=True)
class ArmSizes:
    """Natural sizes of an arm's quantities at states, (states, n), of M (states, n, n).

    level: of a rigid arm; empty with gears.
    """

    case: Case
    layout: Layout
    level: str
    states: States

    @property
    def arm(self) -> Arm:
        """The arm."""
        return self.case.arm

    @cached_property
    def inertia(self) -> np.ndarray:
        """M (states, n, n) by the parallel axis theorem."""
        content = self.arm.model_dump()
        parts = composite.build_parts(content, self.level or "coupled")
        pose = composite.arm_pose(content, self.states.q[:, self.layout.theta])
        return composite.mass_matrix(parts, pose, self.layout)

    @cached_property
    def root(self) -> np.ndarray:
        """Root of M's diagonal (states, n)."""
        return np.sqrt(np.einsum("sii->si", self.inertia))

    @property
    def mass_matrix(self) -> np.ndarray:
        """By Cauchy and Schwarz no entry of M is larger than the root of its two diagonal ones."""
        return self.root[:, :, None] * self.root[:, None, :]

    @property
    def bias(self) -> np.ndarray:
        """Centrifugal forces of the momenta that the motion has, on what the joints turn."""
        v = self.states.v
        motion = np.sqrt(np.einsum("si,sij,sj->s", v, self.inertia, v))
        return self.root * (motion * np.abs(v[:, self.layout.theta]).sum(axis=1))[:, None]

    @cached_property
    def generalized_force(self) -> np.ndarray:
        """Sum of the magnitudes of what acts on each coordinate."""
        torques = _joint_torques(self.case, self.layout, self.states)
        size = _tooth_forces(self.case, self.layout, torques)
        size[:, self.layout.theta] += torques
        return size

    @property
    def corner_force(self) -> np.ndarray:
        """Sizes of the same force at the corners of the mesh laws."""
        return self.generalized_force

    def acceleration(self, values: np.ndarray) -> np.ndarray:
        """What forces of their sizes make by M's inverse, and what solving by M rounds (Skeel)."""
        inverse, mass = np.abs(np.linalg.inv(self.inertia)), np.abs(self.inertia)
        solved = np.einsum("sij,sj->si", mass, np.abs(values)) / self.conditioning
        return np.einsum("sij,sj->si", inverse, self.generalized_force + self.bias + solved)

    @cached_property
    def conditioning(self) -> float:
        """Arcs of gears, and places of bodies, over the displacement that is their difference."""
        if not self.layout.mesh_joints:
            return 1.0
        length = gear_arc(self.arm) + PLACE_ROUNDINGS / ROUNDINGS * arm_reach(self.arm)
        return max(1.0, length / largest_displacement(self.arm))

    def natural_size(self, quantity: str, values: np.ndarray) -> np.ndarray:
        """Sizes of the components of a quantity; values: a model's."""
        if quantity == "acceleration":
            return self.acceleration(values)
        return getattr(self, quantity)

    def limit(self, quantity: str) -> ReasonedLimit:
        """The tolerance of a difference relative to its size."""
        roundings = ROUNDINGS_OF_M if quantity == "mass_matrix" else ROUNDINGS
        value, basis = roundings * EPS, f"{roundings} eps"
        if quantity in OF_TEETH and self.layout.mesh_joints:
            value *= self.conditioning
            basis += f" x {self.conditioning:.0f} (arcs of the gears over mesh displacements)"
        return ReasonedLimit(value, f"{basis} of the natural size: {WORDS[quantity]}")


def _joint_torques(case: Case, layout: Layout, states: States) -> np.ndarray:
    """Sizes of drive, weight and friction of the joints (states, joints) [N m]."""
    theta, rates = (each[:, layout.theta] for each in (states.q, states.v))
    drive = drive_data(case.scenario, len(case.arm.joints))
    # Target and angle may cancel in the torque of one of the two, not of both.
    ways = (torques_along(drive, states.t, s * theta, s * rates) for s in (1, -1))
    friction = [joint.friction_N_m_s_per_rad for joint in case.arm.joints]
    return sum(map(np.abs, ways)) + largest_weights(case.arm) + friction * np.abs(rates)


def _tooth_forces(case: Case, layout: Layout, torques: np.ndarray) -> np.ndarray:
    """Sizes of what motors and teeth do to each coordinate (states, n); torques [N m] of joints.

    On the angles no force of teeth does work, unless springs are a potential, which every tooth
    that passes loads anew. Where a model lets them act on bodies, their moments cancel and leave
    the rounding of arcs, which is ``ArmSizes.conditioning`` times that of displacements.
    """
    size, pressed = motor_forces(case.arm, layout, torques), largest_displacement(case.arm)
    for number, joint in geared_joints(case.arm) if layout.mesh_joints else ():
        waves = joint.ring_teeth if case.switches.mesh_work == "conservative" else 1
        for place, mesh in enumerate(meshes(joint)):
            planet, name = place // len(MESHES), MESHES[place % len(MESHES)]
            force = stiffness_bound(mesh.stiffness) * pressed
            force += mesh_damping(joint, name, planet) * SLIDING_M_PER_S
            size += force * np.abs(layout.displacement(name, number, planet))
            size[:, layout.theta] += force * pressed * waves
    return size
