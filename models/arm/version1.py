"""The first version of the arm file: one mesh for sun and ring, read into the second version."""

from __future__ import annotations

from typing import Any

VERSION = 1
Path = tuple[str, ...]
# Where a field of a first-version joint went, in each of the two meshes.
BOTH: dict[str, Path] = {
    "backlash_m": ("backlash_m",),
    "mesh_stiffness_N_per_m": ("stiffness", "mean_N_per_m"),
    "mesh_stiffness_amplitude_N_per_m": ("stiffness", "amplitude_N_per_m"),
    "tooth_error_m": ("tooth_error_m",),
    "damping_ratio": ("damping_ratio",),
    "tanh_sharpness_per_m": ("tanh_sharpness_per_m",),
}
SUN: dict[str, Path] = {"sun_planet_damping_N_s_per_m": ("damping_N_s_per_m",)}
RING: dict[str, Path] = {
    "planet_ring_damping_N_s_per_m": ("damping_N_s_per_m",),
    "ring_mesh_phase_rad": ("phase_rad",),
}
MESHES = {"sun_mesh": {**BOTH, **SUN}, "ring_mesh": {**BOTH, **RING}}
# What a first-version joint has that stayed where it was.
KEPT = (
    *("sun_teeth", "planet_teeth", "ring_teeth", "planet_count", "module_m", "pressure_angle_deg"),
    *(f"{part}_equivalent_mass_kg" for part in ("sun", "planet", "carrier")),
    *(f"{part}_mass_kg" for part in ("sun", "planet", "carrier", "ring")),
    "ring_inertia_kg_m2",
)
JOINT_KEYS = {*KEPT, *BOTH, *SUN, *RING}
NEW_ARM_KEYS = {"gravity_m_per_s2"}
NEW_LINK_KEYS = {"mass_kg", "inertia_kg_m2"}
NEW_JOINT_KEYS = {
    *("kind", "friction_N_m_s_per_rad", *MESHES),
    *(f"{part}_inertia_kg_m2" for part in ("sun", "planet", "carrier")),
}


def is_first(data: object) -> bool:
    """Whether this is a file's content of the first version."""
    version = data.get("schema_version") if isinstance(data, dict) else None
    return type(version) is int and version == VERSION


def upgraded(data: dict[str, Any]) -> dict[str, Any]:
    """First-version content in the second version's form; what is wrong in it stays wrong.

    Raises ValueError, ``field|what is allowed``, for what only the second version has.
    """
    _require_none_of(NEW_ARM_KEYS, data, "")
    for place, link in enumerate(_tables(data, "links")):
        _require_none_of(NEW_LINK_KEYS, link, f"links[{place}].")
    for place, joint in enumerate(_tables(data, "joints")):
        _require_none_of(NEW_JOINT_KEYS, joint, f"joints[{place}].")
    joints = data.get("joints")
    if isinstance(joints, list | tuple):
        joints = [_joint(joint) if isinstance(joint, dict) else joint for joint in joints]
        data = {**data, "joints": joints}
    return {**data, "schema_version": VERSION + 1}


def old_location(location: list[Any]) -> list[Any]:
    """Where an error in the second version's form lies in the first version's."""
    for mesh, fields in MESHES.items():
        if mesh in location:
            above, below = location[: location.index(mesh)], location[location.index(mesh) + 1 :]
            names = [name for name, path in fields.items() if list(path) == below]
            return [*above, *(names or below)]
    return location


def _joint(joint: dict[str, Any]) -> dict[str, Any]:
    moved = {name: value for name, value in joint.items() if name not in {*BOTH, *SUN, *RING}}
    moved["kind"] = "planetary"
    for mesh, fields in MESHES.items():
        stiffness: dict[str, Any] = {"law": "sine"}
        content: dict[str, Any] = {"stiffness": stiffness}
        for name, path in fields.items():
            if name in joint:
                (stiffness if path[0] == "stiffness" else content)[path[-1]] = joint[name]
        moved[mesh] = content
    return moved


def _tables(data: dict[str, Any], key: str) -> list[dict[str, Any]]:
    found = data.get(key)
    whole = isinstance(found, list | tuple) and all(isinstance(entry, dict) for entry in found)
    return list(found) if whole and found is not None else []


def _require_none_of(keys: set[str], table: dict[str, Any], where: str) -> None:
    for key in table:
        if key in keys:
            raise ValueError(f"{where}{key}|needs schema_version = {VERSION + 1}")
