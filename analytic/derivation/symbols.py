"""The symbols of the model, named as in the paper."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

import sympy as sp

from crosscheck.analytic.derivation.chain import Chain
from crosscheck.analytic.derivation.stage import DirectStage, Stage, exact_fraction, stage_values
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import make_layout

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
    torques = _reals(f"T_{i}" for i in range(1, joints + 1))
    return Variables(_reals(names), rates, _reals(forces), torques)


def _reals(names: Iterable[str]) -> tuple[sp.Symbol, ...]:
    return tuple(sp.Symbol(name, real=True) for name in names)


def parameter_values(arm: Arm) -> dict[sp.Symbol, Fraction]:
    """The number behind every symbol of an arm."""
    values = {m_payload: exact_fraction(arm.payload_mass_kg)}
    for symbols, joint, link in zip(arm_stages(arm), arm.joints, arm.links, strict=True):
        values |= dict(zip(symbols, stage_values(joint, link), strict=True))
    return values


def rational_values(arm: Arm) -> dict[sp.Symbol, sp.Rational]:
    """The same as SymPy has it: other types it converts anew."""
    numbers = parameter_values(arm).items()
    return {symbol: sp.Rational(*value.as_integer_ratio()) for symbol, value in numbers}


def arm_stages(arm: Arm) -> list[Stage | DirectStage]:
    """The symbols of every joint, geared or not."""
    stages: list[Stage | DirectStage] = []
    for number, joint in enumerate(arm.joints, start=1):
        if isinstance(joint, Planetary):
            stages.append(stage_symbols(number))
        else:
            names = (sp.Symbol(f"{name}{number}", positive=True) for name in DirectStage._fields)
            stages.append(DirectStage(*names))
    return stages


def build_symbolic_chain(meshing: Sequence[bool]) -> Chain:
    """The chain of geared joints in symbols; ``meshing``: which have mesh displacements."""
    stages = tuple(stage_symbols(joint) for joint in range(1, len(meshing) + 1))
    return Chain(stages, m_payload, make_layout(meshing))
