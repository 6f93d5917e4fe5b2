"""A start with teeth that already carry the load: what is left of the starting impact then?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crosscheck.audit.experiments.variant import Variant
from crosscheck.models.interface import Model
from crosscheck.registry import build

INSIDE_M = 1e-6  # so far into contact that a mesh's force is a straight line


def preloaded(variant: Variant) -> Variant:
    """The experiment from meshes that do not accelerate at t = 0: the teeth bear the drive.

    All planets alike: they share the load.
    """
    model = build(variant.model, *replace(variant, planets="lumped").case())
    sun, ring = resting_offsets(model).reshape(-1, 2).T
    offsets = {"sun_planet_offset_m": sun, "planet_ring_offset_m": ring}
    start = tuple(f"scenario.start.{name}={list(map(float, x))!r}" for name, x in offsets.items())
    return replace(variant, meshes=(*variant.meshes, *start))


def resting_offsets(model: Model) -> np.ndarray:
    """How far [m] every mesh is beyond its start when none accelerates, (meshes,).

    In the order of the layout. Forces are straight lines while teeth touch, so one step of Newton's
    method is exact.
    """
    meshes = np.flatnonzero(~model.layout.angular)
    pose, rates = model.start()

    def accelerations(offsets: np.ndarray) -> np.ndarray:
        moved = pose.copy()
        moved[meshes] += offsets
        return model.acceleration(0.0, moved, rates)[meshes]

    inside = np.full(meshes.size, INSIDE_M)
    base = accelerations(inside)
    steps = INSIDE_M * np.eye(meshes.size)
    slopes = np.array([accelerations(inside + step) - base for step in steps]).T / INSIDE_M
    return inside - np.linalg.solve(slopes, base)
