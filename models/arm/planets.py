"""Whether the planets of a stage may be counted as one: as data, no law."""

from __future__ import annotations

from collections.abc import Iterator

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.gears import PlanetaryStage
from crosscheck.models.arm.mesh import FROM_TEETH
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario, Switches, switches

ALLOWED = "must be equal for all planets, or needs switches.planets = free"
OUT_OF_PHASE = "puts the planets out of phase and needs switches.planets = free"


def find_unlike_planets(arm: Arm) -> Iterator[tuple[str, object]]:
    """Fields of an arm, and their values, by which planets of one stage differ."""
    for number, joint in enumerate(arm.joints):
        if isinstance(joint, Planetary):
            for field, value in find_unlike_fields(joint):
                yield f"joints[{number}].{field}", value


def find_unlike_fields(joint: PlanetaryStage) -> Iterator[tuple[str, object]]:
    """Fields of one joint, and their values, by which its planets differ."""
    for side, mesh in (("sun_mesh", joint.sun_mesh), ("ring_mesh", joint.ring_mesh)):
        for name, value in vars(mesh).items():
            # Equally spaced planets are in phase if each is a whole number of sun teeth further.
            out_of_phase = name == "phase_rad" and joint.sun_teeth % joint.planet_count
            listed = isinstance(value, tuple) and len(set(value)) > 1
            if (out_of_phase and value == FROM_TEETH) or listed:
                yield f"{side}.{name}", list(value) if listed else value


def usual_switches(arm: Arm, **chosen: str) -> Switches:
    """Switches with the given choices; planets are lumped unless the arm's differ.

    Raises pydantic.ValidationError for an unknown switch or value.
    """
    if "planets" not in chosen and next(find_unlike_planets(arm), None) is not None:
        chosen = {**chosen, "planets": "free"}
    return switches(**chosen)


def require_alike(
    arm: Arm,
    scenario: Scenario | None,
    chosen: Switches,
    arm_file: str = "",
    scenario_file: str = "",
) -> None:
    """Raise InputError if planets are lumped that differ, or that are offset at the start.

    The files are named where the names of arm and scenario do not say them.
    """
    if chosen.planets == "free":
        return
    for field, value in find_unlike_planets(arm):
        allowed = OUT_OF_PHASE if value == FROM_TEETH else ALLOWED
        raise InputError(arm_file or arm.name, field, value, allowed)
    for joint, offsets in enumerate(scenario.start.planet_offset_m if scenario else ()):
        if any(offsets):
            field = f"start.planet_offset_m[{joint}]"
            where = scenario_file or (scenario.name if scenario else "")
            raise InputError(where, field, list(offsets), "needs switches.planets = free")
