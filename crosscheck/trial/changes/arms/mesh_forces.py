"""Forces of meshes at states: by the arm's own law, and by others that a user may follow."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, get_args

import numpy as np
from pydantic import ValidationError

from crosscheck.analytic.derivation.gears import build_gears
from crosscheck.analytic.paper.mesh_force import is_in_contact, mesh_force, phase_force, total_error
from crosscheck.analytic.paper.mesh_frequency import mesh_phase
from crosscheck.analytic.paper.stiffness import stiffness, stiffness_slope
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import Layout
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.experiment.scenario import Switches
from crosscheck.trial.changes.arms.segments import list_meshes
from crosscheck.trial.coordinates.states import UserState

SIDES = {"sp": "sun_mesh", "pr": "ring_mesh"}
SWITCHED = ("phase", "ring_rate", "dead_zone", "damping", "mesh_work")


def compute_signals(
    arm: Arm,
    layout: Layout,
    chosen: Switches,
    states: UserState,
    is_absolute: bool = False,
    rate_factor: np.ndarray | None = None,
) -> dict[str, np.ndarray]:
    """Output torques [N m], forces of a planet's meshes [N], and the dampers' rates [m/s], (K,).

    states: K of them, as arrays; is_absolute, rate_factor: as in ForceVariant. The user's rates,
    ``rate_name`` of each coordinate, are added by the caller.
    """
    signals = {f"T_{j + 1}": states.torque[:, j] for j in range(states.torque.shape[1])}
    data, meshes = build_gears(arm, layout, chosen), list_meshes(arm, layout)
    clock, q, v = states.t[:, None], states.q, states.v
    of_two = data.subtract_index >= 0
    x, rate = (each[:, data.x_index] - of_two * each[:, data.subtract_index] for each in (q, v))
    turned = np.array((q, v))
    if is_absolute:
        turned[:, :, layout.theta] = turned[:, :, layout.theta].cumsum(axis=2)
    rates = data.rate if rate_factor is None else data.rate * rate_factor
    phase = mesh_phase(data.phase, rates, data.offset, clock, *turned[:, :, data.theta])
    gap = x - total_error(phase, data.E, data.error_phase, data.static_error)
    in_contact = is_in_contact(gap, data.b)
    touching = in_contact | data.damps_without_contact
    for i, mesh in enumerate(meshes):
        k = stiffness(data.law, i, phase[:, i], data.k_m[i], data.k_a[i])
        force = mesh_force(data.dead_zone, gap[:, i], k, data.b[i], data.sigma[i])
        signals[mesh.force] = force
        if chosen.damping == "contact":
            signals[mesh.damper] = np.where(touching[:, i], rate[:, i], 0.0)
        if chosen.mesh_work == "conservative":
            k_slope = stiffness_slope(data.law, i, phase[:, i], data.k_a[i])
            error_slope = data.E[i] * np.cos(phase[:, i] + data.error_phase[i])
            on_phase = phase_force(gap[:, i], k, k_slope, error_slope, data.b[i])
            signals[mesh.work] = data.planets[i] * data.rate[i] * on_phase
    return signals


class ForceVariant(NamedTuple):
    """Another law that a user's force may follow: its arm and switches, and the meshes' phases.

    yours, right: what that law is, and in place of which; meshes: where, '' for all; is_absolute:
    whether phases go by absolute link angles; rate_factor: phases faster by factors (meshes,).
    """

    yours: str
    right: str
    meshes: str
    arm: Arm
    switches: Switches
    is_absolute: bool = False
    rate_factor: np.ndarray | None = None

    @property
    def words(self) -> str:
        """What is another by this law."""
        has_phase = self.is_absolute or self.rate_factor is not None
        of = "phase of mesh force" if has_phase else "mesh force"
        return f"{of} {self.meshes}".strip()


# Field, its change, and the words for the user's value and for the right one.
CHANGES: tuple[tuple[str, Callable[[Any], Any], str, str], ...] = (
    ("backlash_m", lambda b: 0.0, "backlash 0", "b"),
    ("backlash_m", lambda b: 2 * b, "2 b", "b"),
    ("backlash_m", lambda b: b / 2, "b/2", "b"),
    ("tooth_error_m", lambda e: 0.0, "no tooth error", "E"),
    ("tooth_error_m", lambda e: 2 * e, "2 E", "E"),
    ("tooth_error_phase_rad", lambda p: p + math.pi, "-E", "E"),
    ("tooth_error_phase_rad", lambda p: 0.0, "no phase of the tooth error", "its phase"),
    ("static_error_m", lambda e: 0.0, "no static error", "e_0"),
    ("static_error_m", lambda e: -e, "-e_0", "e_0"),
    ("phase_rad", lambda p: 0.0, "no phase_rad", "phase_rad"),
    ("phase_rad", lambda p: p if isinstance(p, str) else -p, "-phase_rad", "phase_rad"),
)


def list_mesh_laws(arm: Arm, layout: Layout, chosen: Switches) -> Iterator[ForceVariant]:
    """Laws by other switches; by each change of all meshes, and of one; then by other phases."""
    for name in SWITCHED:
        for other in get_args(Switches.model_fields[name].annotation):
            try:
                switches = Switches.model_validate(chosen.model_dump() | {name: other})
            except ValidationError:  # two laws that do not go together
                continue
            if switches != chosen:
                right = f"{name} = {getattr(chosen, name)}"
                yield ForceVariant(f"{name} = {other}", right, "", arm, switches)
    geared = [j for j, joint in enumerate(arm.joints) if isinstance(joint, Planetary)]
    single = [(joint, pair) for joint in geared for pair in SIDES]
    for field, change, yours, right in CHANGES:
        for where in (single, *([mesh] for mesh in single)) if len(single) > 1 else (single,):
            other_arm = _change_meshes(arm, where, field, change)
            if other_arm != arm:
                meshes = ", ".join(f"{pair}{joint + 1}" for joint, pair in where)
                yield ForceVariant(yours, right, meshes, other_arm, chosen)
    yield from _list_phase_laws(arm, layout, chosen)


def _list_phase_laws(arm: Arm, layout: Layout, chosen: Switches) -> Iterator[ForceVariant]:
    """Laws by absolute angles; by the teeth of another gear, at all meshes or a single one."""
    later = ", ".join(f"theta_{joint + 1}" for joint in layout.mesh_joints if joint)
    if later:
        yield ForceVariant("the absolute angle", f"the joint's {later}", "", arm, chosen, True)
    meshes = list_meshes(arm, layout)
    joints: list[Any] = [arm.joints[mesh.joint] for mesh in meshes]  # planetary, as they mesh
    for teeth, field in (("z_s", "sun_teeth"), ("z_p", "planet_teeth")):
        faster = np.array([float(getattr(joint, field) / joint.ring_teeth) for joint in joints])
        yield ForceVariant(teeth, "z_r", "", arm, chosen, rate_factor=faster)


def _change_meshes(
    arm: Arm, where: Sequence[tuple[int, str]], field: str, change: Callable[[Any], Any]
) -> Arm:
    """The arm with a field of these meshes changed, for all planets or each planet's."""
    joints = list(arm.joints)
    for place, pair in where:
        mesh: Mesh = getattr(joints[place], SIDES[pair])
        value = getattr(mesh, field)
        other = tuple(map(change, value)) if isinstance(value, tuple) else change(value)
        changed = mesh.model_copy(update={field: other})
        joints[place] = joints[place].model_copy(update={SIDES[pair]: changed})
    return arm.model_copy(update={"joints": tuple(joints)})
