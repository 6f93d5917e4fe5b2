"""The symbols of the model, named as in the paper, and their values for an arm."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

import sympy as sp

from analytic.kinematics import stage_geometry
from models.arm import Arm, Joint, Link


class StageSymbols(NamedTuple):
    """Symbols of one stage and the link that it drives.

    M_s, M_p, M_c: equivalent masses [kg]; m_s, m_p, m_c, m_r: masses [kg]; J_r: ring inertia
    [kg m^2]; r_s, r_p, r_c, r_cp: radii [m]; n: ratio; N: planets; m, I_l, d, L: the link's mass
    [kg], inertia about its centre [kg m^2], centre [m] and length [m].
    """

    M_s: sp.Symbol
    M_p: sp.Symbol
    M_c: sp.Symbol
    m_s: sp.Symbol
    m_p: sp.Symbol
    m_c: sp.Symbol
    m_r: sp.Symbol
    J_r: sp.Symbol
    r_s: sp.Symbol
    r_p: sp.Symbol
    r_c: sp.Symbol
    r_cp: sp.Symbol
    n: sp.Symbol
    N: sp.Symbol
    m: sp.Symbol
    I_l: sp.Symbol
    d: sp.Symbol
    L: sp.Symbol


m_payload = sp.Symbol("m_payload", positive=True)


@lru_cache
def stage_symbols(joint: int) -> StageSymbols:
    """Symbols of the stage of joint 1, 2, ..."""
    return StageSymbols(
        *(sp.Symbol(f"{name}{joint}", positive=True) for name in StageSymbols._fields)
    )


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


@lru_cache
def rigid_variables(joints: int) -> Variables:
    """The variables of Eq. 1: joint angles alone."""
    names = [f"theta_{i}" for i in range(1, joints + 1)]
    return Variables(_reals(names), _reals(f"d{name}" for name in names), (), _torques(joints))


def _reals(names: Iterable[str]) -> tuple[sp.Symbol, ...]:
    return tuple(sp.Symbol(name, real=True) for name in names)


def _torques(joints: int) -> tuple[sp.Symbol, ...]:
    return _reals(f"T_{i}" for i in range(1, joints + 1))


def parameter_values(arm: Arm) -> dict[sp.Symbol, float]:
    """The number behind every symbol, for this arm."""
    values = {m_payload: arm.payload_mass_kg}
    for number, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True), start=1):
        stage = stage_symbols(number)
        values |= dict(zip(stage, _stage_values(joint, link), strict=True))
    return values


def _stage_values(joint: Joint, link: Link) -> tuple[float, ...]:
    geometry = stage_geometry(joint)
    mass = link.density_kg_per_m3 * link.cross_section_m2 * link.length_m
    return (
        joint.sun_equivalent_mass_kg,
        joint.planet_equivalent_mass_kg,
        joint.carrier_equivalent_mass_kg,
        joint.sun_mass_kg,
        joint.planet_mass_kg,
        joint.carrier_mass_kg,
        joint.ring_mass_kg,
        joint.ring_inertia_kg_m2,
        geometry.r_s,
        geometry.r_p,
        geometry.r_c,
        geometry.r_cp,
        geometry.n,
        float(joint.planet_count),
        mass,
        mass * link.length_m**2 / 12,  # slender rod
        link.com_m,
        link.length_m,
    )
