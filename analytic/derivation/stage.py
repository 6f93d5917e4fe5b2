"""The quantities of a stage, named as in the paper, and their values for an arm."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any, NamedTuple

from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.models.arm.arm import Direct, Link, Planetary
from crosscheck.models.arm.gears import PlanetaryGears


class Stage(NamedTuple):
    """Quantities of one geared stage and the link that it drives, symbols or numbers.

    M_s, M_p, M_c: equivalent masses [kg]; m_s, m_p, m_c, m_r: masses [kg]; J_r: ring inertia
    [kg m^2]; r_s, r_p, r_c, r_cp: radii [m]; n: ratio; N: planets; m, I_l, d, L: the link's mass
    [kg], inertia about its centre [kg m^2], centre [m] and length [m].
    """

    M_s: Any
    M_p: Any
    M_c: Any
    m_s: Any
    m_p: Any
    m_c: Any
    m_r: Any
    J_r: Any
    r_s: Any
    r_p: Any
    r_c: Any
    r_cp: Any
    n: Any
    N: Any
    m: Any
    I_l: Any
    d: Any
    L: Any


class DirectStage(NamedTuple):
    """Quantities of a joint without gears and the link that it drives.

    m_m: mass of the motor [kg]; J_m: inertia of its rotor [kg m^2]; the others as in Stage.
    """

    m_m: Any
    J_m: Any
    m: Any
    I_l: Any
    d: Any
    L: Any


def exact_fraction(value: float) -> Fraction:
    """The number that a floating-point number is, so that what cancels does so without a rest."""
    return Fraction(value)


def stage_values(
    joint: Planetary | Direct, link: Link, number: Callable[[float], Any] = exact_fraction
) -> Stage | DirectStage:
    """The numbers of one stage and the link that it drives, in fractions unless stated."""
    values = map(number, _values(joint, link))
    return DirectStage(*values) if isinstance(joint, Direct) else Stage(*values)


def _values(joint: Planetary | Direct, link: Link) -> tuple[float, ...]:
    """Numbers of a joint and its link, in the order of the fields of its Stage or DirectStage."""
    mass, inertia = _link_inertia(link)
    on_link = (mass, inertia, link.com_m, link.length_m)
    if isinstance(joint, Direct):
        return joint.motor_mass_kg, joint.rotor_inertia_kg_m2, *on_link
    return *_gear_values(joint), *on_link


def equivalent_masses(joint: Planetary) -> tuple[float, float, float]:
    """M_s, M_p, M_c [kg]: M = J / r^2 (Section 2), as given or from the inertias."""
    radius = stage_geometry(joint).r_cp
    carrier = _equivalent_mass(
        joint.carrier_equivalent_mass_kg, joint.carrier_inertia_kg_m2, radius
    )
    return *gear_masses(joint), carrier


def gear_masses(gears: PlanetaryGears) -> tuple[float, float]:
    """M_s, M_p [kg] of sun and planet: M = J / r^2, as given or from the inertias."""
    geometry = stage_geometry(gears)
    return (
        _equivalent_mass(gears.sun_equivalent_mass_kg, gears.sun_inertia_kg_m2, geometry.r_s),
        _equivalent_mass(gears.planet_equivalent_mass_kg, gears.planet_inertia_kg_m2, geometry.r_p),
    )


def _equivalent_mass(mass: float | None, inertia: float | None, radius: float) -> float:
    if mass is not None:
        return mass
    assert inertia is not None  # the arm's own validation
    return inertia / radius**2


def _gear_values(joint: Planetary) -> tuple[float, ...]:
    geometry = stage_geometry(joint)
    return (
        *equivalent_masses(joint),
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
    )


def _link_inertia(link: Link) -> tuple[float, float]:
    """Mass [kg], and inertia [kg m^2] about the centre of mass: given, or of a slender rod."""
    if link.mass_kg is not None and link.inertia_kg_m2 is not None:
        return link.mass_kg, link.inertia_kg_m2
    assert link.density_kg_per_m3 is not None  # the arm's own validation
    assert link.cross_section_m2 is not None
    mass = link.density_kg_per_m3 * link.cross_section_m2 * link.length_m
    return mass, mass * link.length_m**2 / 12
