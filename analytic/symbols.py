"""The symbols of the model, named as in the paper."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

import sympy as sp

from analytic.chain import Chain
from analytic.stage import Stage, exact, stage_values
from models.arm import Arm
from models.layout import layout_of

m_payload = sp.Symbol("m_payload", positive=True)


@lru_cache
def stage_symbols(joint: int) -> Stage:
    """Symbols of the stage of joint 1, 2, ..."""
    return Stage(*(sp.Symbol(f"{name}{joint}", positive=True) for name in Stage._fields))


class Variables(NamedTuple):
    """Coordinates, rates, mesh forces (per planet) and output torques of a form.

    q and v are in the paper's order (Eq. 20); x_sp, x_pr, theta are views of q, joint by joint.
    """

    q: tuple[sp.Symbol, ...]
    v: tuple[sp.Symbol, ...]
    mesh_forces: tuple[sp.Symbol, ...]
    torques: tuple[sp.Symbol, ...]


@lru_cache
def geared_variables(joints: int) -> Variables:
    """The variables of Eqs. 20-22; mesh forces in the order F_sp1, F_pr1, F_sp2, ..."""
    names = [f"{name}{i}" for i in range(1, joints + 1) for name in ("x_sp", "x_pr", "theta_")]
    forces = [f"{name}{i}" for i in range(1, joints + 1) for name in ("F_sp", "F_pr")]
    rates = _reals(f"d{name}" for name in names)
    return Variables(_reals(names), rates, _reals(forces), _torques(joints))


def _reals(names: Iterable[str]) -> tuple[sp.Symbol, ...]:
    return tuple(sp.Symbol(name, real=True) for name in names)


def _torques(joints: int) -> tuple[sp.Symbol, ...]:
    return _reals(f"T_{i}" for i in range(1, joints + 1))


def parameter_values(arm: Arm) -> dict[sp.Symbol, Fraction]:
    """The number behind every symbol, for an arm with gears in all joints."""
    values = {m_payload: exact(arm.payload_mass_kg)}
    for number, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True), start=1):
        values |= dict(zip(stage_symbols(number), stage_values(joint, link), strict=True))
    return values


def symbolic_chain(meshing: Sequence[bool]) -> Chain:
    """Geared joints in symbols; ``meshing``: which of them have mesh displacements."""
    stages = tuple(stage_symbols(joint) for joint in range(1, len(meshing) + 1))
    return Chain(stages, m_payload, layout_of(meshing))
