"""An arm with other teeth: what is changed in all its meshes at once."""

from __future__ import annotations

import math
from collections.abc import Callable

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.stiffness import SineStiffness, SquareStiffness
from crosscheck.models.errors import InputError

SINGLE_SINE_RATIO = 1.5  # the contact ratio at which Eq. 7's fundamental is a sine without phase


def change_meshes(arm: Arm, change: Callable[[Mesh], Mesh]) -> Arm:
    """The arm with both meshes of every geared joint changed; direct joints as they are."""
    joints = [
        joint.model_copy(
            update={"sun_mesh": change(joint.sun_mesh), "ring_mesh": change(joint.ring_mesh)}
        )
        if isinstance(joint, Planetary)
        else joint
        for joint in arm.joints
    ]
    return arm.model_copy(update={"joints": tuple(joints)})


def replace_damping(arm: Arm, zeta: float) -> Arm:
    """The arm with this damping ratio in place of its meshes' damping. Raises ValidationError."""
    update = {"damping_ratio": zeta, "damping_N_s_per_m": None}
    return change_meshes(arm, lambda mesh: Mesh.model_validate({**dict(mesh), **update}))


def replace_by_square_wave(arm: Arm, harmonics: int) -> Arm:
    """The arm with the square wave of Fig. 5 whose mean and fundamental are those of Eq. 8.

    harmonics: how many of Eq. 7. Raises InputError for a mesh that has not Eq. 8's stiffness.
    """
    return change_meshes(arm, lambda mesh: _square_wave_mesh(arm, mesh, harmonics))


def _square_wave_mesh(arm: Arm, mesh: Mesh, harmonics: int) -> Mesh:
    law = mesh.planet_mesh(0).stiffness
    if not isinstance(law, SineStiffness):
        raise InputError(arm.name, "stiffness", law.law, "must be sine, the paper's Eq. 8")
    half = math.pi / 4 * law.amplitude_N_per_m
    wave = SquareStiffness(
        law="square",
        contact_ratio=SINGLE_SINE_RATIO,
        least_N_per_m=law.mean_N_per_m - half,
        largest_N_per_m=law.mean_N_per_m + half,
        harmonics=harmonics,
    )
    return mesh.model_copy(update={"stiffness": wave})
