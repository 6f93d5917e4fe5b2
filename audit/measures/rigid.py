"""The rigid arm in the experiment of a geared one: what measures compare runs with."""

from __future__ import annotations

from dataclasses import replace

from crosscheck.audit.experiments.variant import GEARED_MODELS, Variant

COUPLED = "coupled"  # the level with all that the gears bring along rigidly
PRINTED_RIGID = "analytic:printed-rigid"  # the same of the printed equations: their own limit
RIGID_STEP_S = 1e-4  # the rigid arm is smooth


def rigid_model(level: str, geared: str = GEARED_MODELS["corrected"]) -> str:
    """The name of the model of a rigid level, beside a geared model.

    With all that gears bring along, the printed equations have a rigid limit of their own: with any
    other an error of theirs would count as the meshes' doing.
    """
    if level == COUPLED and geared == GEARED_MODELS["printed"]:
        return PRINTED_RIGID
    return f"analytic:{level}"


def rigid_arm(variant: Variant, level: str = COUPLED) -> Variant:
    """The rigid arm at a level through the same experiment, every step recorded.

    Nothing is left that concerns the meshes alone, so geared runs share one rigid arm.
    """
    return replace(
        remove_gears(variant, level),
        settings=(*variant.settings, f"scenario.step_s={RIGID_STEP_S!r}"),
        record_every=1,
    )


def remove_gears(variant: Variant, level: str = COUPLED) -> Variant:
    """The rigid arm at a level in the same experiment, at the geared run's step and records."""
    fields = Variant()
    return replace(
        variant,
        model=rigid_model(level, variant.model),
        phase=fields.phase,
        ring_rate=fields.ring_rate,
        zeta=fields.zeta,
        seed=fields.seed,
        meshes=fields.meshes,
        planets=fields.planets,
        mesh_work=fields.mesh_work,
        harmonics=fields.harmonics,
    )
