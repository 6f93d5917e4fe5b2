"""Mesh modes: the frequencies at which the teeth ring."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from crosscheck.findings import Finding, checked, failed
from models.arm import Joint
from models.interface import Model

TOLERANCE = 1e-6
BASIS = "1e-6: engines linearise by finite differences of forces of 1e4 N at 1e-7 relative steps"
# A carrier is locked by a link this many times heavier: the modes move by about its inverse.
LOCK = 1e9


def compare_modes(case: str, models: Sequence[Model]) -> Iterator[Finding]:
    """Every mode of the model that has fewer must be a mode of the other."""
    able = [model for model in models if "mesh_modes" in model.abilities]
    for left, right in combinations(able, 2):
        fields: dict[str, Any] = {
            "id": f"modes/{case}/{left.name}~{right.name}",
            "quantity": "mesh mode",
            "unit": "1",
            "left": left.name,
            "right": right.name,
            "metric": "largest relative distance of a mode to the nearest of the other model",
        }
        try:
            few, many = sorted((left.mesh_modes(), right.mesh_modes()), key=len)
        except Exception as error:  # a model that raises is a failed check
            yield failed(note=f"{type(error).__name__}: {error}", **fields)
            continue
        yield _checked(few, many, fields)


def locked_stage(case: str, joint: Joint, locked: Model) -> Iterator[Finding]:
    """The modes of one stage, carrier locked, against their closed form.

    ``locked``: a one-joint model of this joint whose link is LOCK times too heavy.
    """
    fields: dict[str, Any] = {
        "id": f"modes/{case}/locked-stage/{locked.name}",
        "quantity": "mesh mode",
        "unit": "1",
        "left": "closed form",
        "right": locked.name,
        "metric": "largest relative distance of a mode to the nearest of the other model",
    }
    yield _checked(closed_form_modes(joint), locked.mesh_modes(), fields)


def closed_form_modes(joint: Joint) -> np.ndarray:
    """Both modes [Hz] of a stage with its carrier locked, ascending.

    With u = r_s theta_s and w = r_p theta_p: M_s u'' = -K (u - w) and N M_p w'' = K (u - w) - K w,
    K = N k, so omega^2 solves a quadratic.
    """
    stiffness = joint.planet_count * joint.mesh_stiffness_N_per_m
    sun = stiffness / joint.sun_equivalent_mass_kg
    planets = stiffness / (joint.planet_count * joint.planet_equivalent_mass_kg)
    mean, product = (sun + 2 * planets) / 2, sun * planets
    root = np.sqrt(mean**2 - product)
    return np.sqrt(np.array([mean - root, mean + root])) / (2 * np.pi)


def _checked(few: np.ndarray, many: np.ndarray, fields: dict[str, Any]) -> Finding:
    distance = np.abs(few[:, None] - many[None, :]).min(axis=1) / few
    measured = float(distance.max())
    return checked(
        measured=measured,
        tolerance=TOLERANCE,
        basis=BASIS,
        relative=measured,
        note="modes [Hz]: " + ", ".join(f"{mode:.2f}" for mode in few),
        **fields,
    )
