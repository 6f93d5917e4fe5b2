"""What `compare` says while a fault is in it: by a second program, stage by stage."""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from crosscheck.models.pinocchio.rigid import PinocchioCoupled
from crosscheck.recordings import (
    compare,
    engines,
    forward,
    friction,
    gravity,
    parameters,
    record,
    residual,
    smoothing,
)
from crosscheck.recordings.smoothing import Block
from crosscheck.registry import RIGID_LEVELS
from tests.faults.planting import Seen
from tests.measured import guards, second
from tests.measured.guards import HEAVY, RIGHT


def numbers_agree(seen: Seen) -> str:
    """The numbers of a stage: quantity, of a kind of record: arm."""
    return "differ" if any(STAGES[seen.quantity](seen.arm)) else "agree"


@lru_cache
def kept_blocks(kind: str) -> list[Block]:
    """Of the record, by code without a fault."""
    return _blocks(kind)


@lru_cache
def kept_normal(kind: str, level: str) -> residual.NormalEquations:
    """Normal equations of a level, by code without a fault."""
    return _normal(kind, level)


def _blocks(kind: str) -> list[Block]:
    own = guards.measured(kind)[0].record
    assert own.torques is not None
    return list(smoothing.smooth_record(own, own.torques, smoothing.select_spacing(own)))


def _normal(kind: str, level: str) -> residual.NormalEquations:
    among = parameters.find_parameters(guards.arm())
    return compare._build_equations(
        kept_blocks(kind), guards.arm(), level, among, lambda *doing: None
    )


def _smoothing(kind: str) -> Iterator[str]:
    found, right = guards.measured(kind)
    pieces = _blocks(kind)
    noises = (compare._mean_noise(pieces, name) for name in ("angle_noise", "torque_noise"))
    angles, torques = noises
    data = guards.data_of(replace(found, angle_noise=angles, torque_noise=torques))
    yield from guards.wrong_smoothing(data, right)
    for piece, own in zip(pieces, right.pieces, strict=True):
        for said, signal in zip(piece.motion, own.motion, strict=True):
            yield from guards.apart(
                "motion", said / np.abs(signal).max(), signal / np.abs(signal).max(), 1e-5
            )


def _levels(kind: str) -> Iterator[str]:
    found, right = guards.measured(kind)
    models = [engines.build_rigid_model(level, guards.arm()) for level in RIGID_LEVELS]
    fits = residual.fit_models(kept_blocks(kind), models, lambda rows: None)
    levels = compare._rank_levels(dict(zip(RIGID_LEVELS, fits, strict=True)))
    changed = replace(found, levels=levels)
    yield from guards.wrong_levels(guards.data_of(changed), right)
    yield from guards.wrong_limits(changed)


def _equations(kind: str) -> Iterator[str]:
    normals = {level: _normal(kind, level) for level in {guards.measured(kind)[1].best, "coupled"}}
    yield from _estimated(kind, normals)


def _estimates(kind: str) -> Iterator[str]:
    levels = {guards.measured(kind)[1].best, "coupled"}
    yield from _estimated(kind, {level: kept_normal(kind, level) for level in levels})


def _estimated(kind: str, normals: dict[str, residual.NormalEquations]) -> Iterator[str]:
    found, right = guards.measured(kind)
    among = parameters.find_parameters(guards.arm())
    count = len(among)
    best = normals[right.best].leading(count)
    base, condition = parameters.estimate_together(best, among)
    changed = replace(
        found,
        residual_chi2=best.chi2,
        residual_freedom=best.freedom,
        single=tuple(parameters.estimate_separately(best, among)),
        base=tuple(base),
        condition=condition,
        repairs=tuple(compare._find_repairs(normals["coupled"], "coupled", guards.arm(), among)),
        frictions=(friction.fit_friction(normals["coupled"], "coupled", guards.arm(), among),),
        gravities=(
            gravity.fit_gravity(
                normals["coupled"], "coupled", guards.arm(), range(count, count + 2)
            ),
        ),
    )
    data = guards.data_of(changed)
    if kind == RIGHT:  # there is nothing to explain
        data["explained_by"] = []
    rubs = compare._find_frictions(normals["coupled"], "coupled", guards.arm(), among)
    if bool(data["explained_by"]) != (kind == HEAVY):
        yield "what explains the record"
    if bool(rubs) != (kind != HEAVY):
        yield "which friction explains the record"
    yield from guards.apart("own chi2", data["own_chi2"], right.levels[right.best].chi2)
    yield from guards.wrong_estimates(data, right)
    yield from guards.wrong_frictions(data, right)
    yield from guards.wrong_gravities(data, right)


def _runs(kind: str) -> Iterator[str]:
    found, right = guards.measured(kind)
    made = forward.run_windows(kept_blocks(kind), guards.arm(), right.best, guards.TOLERANCES)
    changed = replace(found, windows=tuple(made))
    yield from guards.wrong_windows(guards.data_of(changed), guards.right_windows(kind))
    yield from guards.wrong_run_pictures(changed, guards.right_windows(kind))


def _engines(kind: str) -> Iterator[str]:
    """Pinocchio is off in one row by just less than the tolerance, by just more and by a tenth."""
    motion, right = kept_blocks(kind)[0].motion, PinocchioCoupled.inverse_dynamics
    size = _size(kind)
    lengths = [link["length_m"] for link in guards.content()["links"]]
    limit = 1000 * np.finfo(float).eps * sum(lengths) / min(lengths)
    for share, agrees in ((0.95 * limit, True), (1.05 * limit, False), (0.1, False)):

        def harmed(*state: np.ndarray, more: float = share * size) -> np.ndarray:
            torques = right(*state)
            torques[157, 1] += more
            return torques

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(PinocchioCoupled, "inverse_dynamics", harmed)
            found = engines.compare_arm_engines(motion, guards.arm())
        if [each.verdict == "agree" for each in found] != [True, True, True, agrees]:
            yield f"{share} of a torque: {found}"
        if share == 0.1 and not found[-1].note.startswith("pinocchio:coupled stands alone"):
            yield f"{found[-1]}"
        yield from guards.apart("difference", found[-1].measured, share, 1e-2)
        yield from guards.apart("tolerance", found[-1].tolerance, limit)


@lru_cache
def _size(kind: str) -> float:
    """The largest sum of the sizes of the terms of joint 2's torque [N m], in one row."""
    angles, rates, accelerations = kept_blocks(kind)[0].motion
    bodies = second.Bodies(guards.content(), "coupled")
    weight = bodies.torques(angles, 0 * rates, 0 * rates)
    size = np.abs(weight) + np.abs(bodies.torques(angles, rates, 0 * rates) - weight)
    for joint in np.eye(2):
        size += np.abs(bodies.torques(angles, 0 * rates, accelerations * joint) - weight)
    return float(size[:, 1].max())


def _lines(kind: str) -> Iterator[str]:
    yield from guards.wrong_lines(guards.measured(kind)[0])


def _page(kind: str) -> Iterator[str]:
    yield from guards.wrong_page(guards.measured(kind)[0])


def _json(kind: str) -> Iterator[str]:
    found, right = guards.measured(kind)
    data = guards.data_of(found)
    yield from guards.wrong_smoothing(data, right)
    yield from guards.wrong_levels(data, right)
    yield from guards.wrong_estimates(data, right)
    yield from guards.wrong_frictions(data, right)
    yield from guards.wrong_windows(data, guards.right_windows(kind))


def _picture(kind: str) -> Iterator[str]:
    found, right = guards.measured(kind)
    curves = compare._compute_curves(
        kept_blocks(kind), guards.arm(), right.best, found.explanations
    )
    yield from guards.wrong_pictures(replace(found, curves=tuple(curves)), right)


def _run_pictures(kind: str) -> Iterator[str]:
    yield from guards.wrong_run_pictures(guards.measured(kind)[0], guards.right_windows(kind))


UNITS = (
    "t_ms,theta_1_deg,theta_2_deg,theta_dot_1_rpm,theta_dot_2_deg_per_s,torque_1_mN_m,torque_2_N_m"
)


def _reading(kind: str) -> Iterator[str]:
    """A file in other units."""
    time = 0.1 * np.arange(64.0)
    angles, rates = np.column_stack([np.sin(time), np.cos(time)]), np.column_stack([time, -time])
    torques = np.column_stack([time**2, 3 * time])
    columns = [1e3 * time, *np.degrees(angles).T, rates[:, 0] * 30 / np.pi]
    columns += [np.degrees(rates[:, 1]), 1e3 * torques[:, 0], torques[:, 1]]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "record.csv"
        np.savetxt(path, np.column_stack(columns), delimiter=",", header=UNITS, comments="")
        found = record.read_record(path, 2)
    right = {"time": time, "angles": angles, "rates": rates, "torques": torques}
    for name, values in right.items():
        yield from guards.apart(name, getattr(found, name), values)


STAGES = {
    "smoothing": _smoothing,
    "levels": _levels,
    "equations": _equations,
    "estimates": _estimates,
    "runs": _runs,
    "engines": _engines,
    "lines": _lines,
    "page": _page,
    "json": _json,
    "picture": _picture,
    "run pictures": _run_pictures,
    "reading": _reading,
    "possible frictions": lambda kind: guards.wrong_possible_frictions(),
    "order": lambda kind: guards.wrong_order(),
    "drive": lambda kind: guards.wrong_drive_torques(),
    "choice": lambda kind: guards.wrong_choice(),
    "witness": lambda kind: guards.wrong_witness(),
}
