"""A stage as the paper has it: geared, with two equal meshes and Eq. 8's stiffness."""

from __future__ import annotations

from dataclasses import dataclass

from crosscheck.analytic.derivation.stage import equivalent_masses
from crosscheck.analytic.paper.kinematics import StageGeometry, stage_geometry
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.planets import find_unlike_planets
from crosscheck.models.arm.stiffness import SineStiffness
from crosscheck.models.errors import InputError


@dataclass(frozen=True)
class PaperStage:
    """The gears of one joint, and what Table I says of its meshes.

    geometry: radii [m] and ratio; sun_equivalent_mass_kg: M_s; mesh_stiffness_N_per_m,
    mesh_stiffness_amplitude_N_per_m: k_m and k_a of Eq. 8; damping_ratio: the sun mesh's, None if
    its damping is given directly.
    """

    joint: Planetary
    geometry: StageGeometry
    sun_equivalent_mass_kg: float
    mesh_stiffness_N_per_m: float
    mesh_stiffness_amplitude_N_per_m: float
    backlash_m: float
    tooth_error_m: float
    tanh_sharpness_per_m: float
    damping_ratio: float | None


def geared_joint(arm: Arm, place: int = 0) -> Planetary:
    """The joint at a place from the base, counted from 0; InputError for one without gears."""
    joint = arm.joints[place]
    if isinstance(joint, Planetary):
        return joint
    where = f"joints[{place}].kind"
    raise InputError(arm.name, where, joint.kind, "must be planetary, as in the paper")


def paper_stage(arm: Arm, place: int = 0) -> PaperStage:
    """The stage of the joint at a place from the base, counted from 0: the shoulder's.

    Raises InputError for a joint that is not as the paper's.
    """
    joint, where = geared_joint(arm, place), f"joints[{place}]"
    mesh, law = joint.sun_mesh.planet_mesh(0), joint.sun_mesh.planet_mesh(0).stiffness
    if not isinstance(law, SineStiffness):
        field = f"{where}.sun_mesh.stiffness"
        raise InputError(arm.name, field, law.law, "must be sine, the paper's Eq. 8")
    if _strip_phase_and_damping(joint.sun_mesh) != _strip_phase_and_damping(joint.ring_mesh):
        raise InputError(arm.name, f"{where}.ring_mesh", None, "must be as sun_mesh, in the paper")
    for field, value in find_unlike_planets(arm):
        raise InputError(arm.name, field, value, "must be one for all planets, as in the paper")
    sun_mass, *_ = equivalent_masses(joint)
    return PaperStage(
        joint=joint,
        geometry=stage_geometry(joint),
        sun_equivalent_mass_kg=sun_mass,
        mesh_stiffness_N_per_m=law.mean_N_per_m,
        mesh_stiffness_amplitude_N_per_m=law.amplitude_N_per_m,
        backlash_m=mesh.backlash_m,
        tooth_error_m=mesh.tooth_error_m,
        tanh_sharpness_per_m=mesh.tanh_sharpness_per_m,
        damping_ratio=mesh.damping_ratio,
    )


def _strip_phase_and_damping(mesh: Mesh) -> Mesh:
    """The mesh without phase and damping: for the rest the paper has one value in both meshes."""
    return mesh.model_copy(
        update={"phase_rad": 0.0, "damping_ratio": None, "damping_N_s_per_m": None}
    )
