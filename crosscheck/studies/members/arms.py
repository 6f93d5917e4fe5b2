"""Members of a study that are arms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.meshes import change_meshes
from crosscheck.models.arm.stiffness import SineStiffness
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import Case, require_fitting, validate_record, validate_switches
from crosscheck.models.trajectory import build_trajectory
from crosscheck.registry import (
    MODELS,
    RIGID_LEVELS,
    build,
    find_level_models,
    reference_model,
    second_engine,
)
from crosscheck.studies.definition.quantities import ARM_SIGNALS
from crosscheck.studies.members.cases import MemberCase, Raw

if TYPE_CHECKING:
    import xarray as xr

    from crosscheck.analytic.model import AnalyticModel
    from crosscheck.studies.definition.definition import Definition

# In place of all meshes, which a rigid arm has none of.
ANY_MESH = Mesh(
    stiffness=SineStiffness(law="sine", mean_N_per_m=1.0, amplitude_N_per_m=0.0),
    backlash_m=0.0,
    tooth_error_m=0.0,
    damping_ratio=0.0,
)


def read_member(
    data: Raw, definition: Definition, scenario: Scenario, arm: Arm | None
) -> MemberCase:
    """The case of a study's data; arm: where it is read already. Raises InputError."""
    arm = arm or validate_record(Arm, data["arm"], definition.mechanism)
    laws = validate_switches(data["switches"], arm)
    planets, is_free = arm.planet_counts, laws.planets == "free"
    return MemberCase(
        arm,
        scenario,
        laws,
        None,
        signals=ARM_SIGNALS,
        rigid_levels=RIGID_LEVELS,
        second_model=second_engine(),
        planet_counts=planets,
        free_planets=[count if is_free else 0 for count in planets],
        mesh_count=2 * sum(count if is_free else min(count, 1) for count in planets),
    )


def require_fit(case: MemberCase, definition: Definition) -> None:
    """Raise InputError unless arm, scenario and switches fit each other."""
    require_fitting(Case(*case.experiment), definition.mechanism, definition.scenario)


def make_model(case: MemberCase) -> AnalyticModel:
    """The reference model of a member. Raises InputError."""
    model: Any = build(reference_model(), *case.experiment)
    return model


def find_rigid_model(
    case: MemberCase, level: str, smooth: Scenario
) -> tuple[object, Callable[[], Any]]:
    """Key of the rigid model in a smooth experiment, and the function that builds it."""
    name = next(name for name in find_level_models(level) if MODELS[name].order is not None)
    stripped = change_meshes(case.mechanism, lambda mesh: ANY_MESH)
    return (stripped, smooth), partial(build, name, stripped, smooth)


def make_run(case: MemberCase, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> xr.Dataset:
    """The Dataset of a run with these signals over time [s]."""
    variables: dict[str, Any] = dict(signals)
    return build_trajectory("ensemble", *Case(*case.experiment), time, **variables)
