"""An arm with other teeth: what is changed in all its meshes at once."""

from __future__ import annotations

from collections.abc import Callable

from models.arm import Arm, Direct, Planetary
from models.mesh import Mesh


def with_meshes(arm: Arm, change: Callable[[Mesh], Mesh]) -> Arm:
    """The arm with both meshes of every geared joint changed; direct joints as they are."""
    joints = tuple(_with_meshes(joint, change) for joint in arm.joints)
    return arm.model_copy(update={"joints": joints})


def _with_meshes(joint: Planetary | Direct, change: Callable[[Mesh], Mesh]) -> Planetary | Direct:
    if isinstance(joint, Direct):
        return joint
    meshes = {"sun_mesh": change(joint.sun_mesh), "ring_mesh": change(joint.ring_mesh)}
    return joint.model_copy(update=meshes)


def damped(arm: Arm, zeta: float) -> Arm:
    """This damping ratio in place of whatever damps the meshes. Raises ValidationError."""
    update = {"damping_ratio": zeta, "damping_N_s_per_m": None}
    return with_meshes(arm, lambda mesh: Mesh.model_validate({**dict(mesh), **update}))
