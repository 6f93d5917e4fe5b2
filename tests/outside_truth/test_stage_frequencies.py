"""Natural frequencies of one stage with planets alike, ring held and carrier free, in closed form.

In u = r theta (base radii of sun and planet, r_cp of the carrier; all rates against the ring's
body) a stage of N planets alike has T = m_s u_s'^2 / 2 + m_c u_c'^2 / 2 + sum m_p u_p'^2 / 2 and
V = sum over planets of k_s (u_s - u_p - u_c)^2 / 2 + k_r (u_p - u_c)^2 / 2. Planets that swing
against each other, sum u_p = 0, leave sun and carrier at rest: m_p w^2 = k_s + k_r, N - 1 times.
Planets that move alike leave three equations for u_s, u_p and u_c: gears that roll without
loading a tooth, w = 0, and the two roots of a quadratic in w^2. So A. Kahraman, "Natural modes of
planetary gear trains", J. Sound Vib. 173 (1994) 125-130, with N = 2 to 6.
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.interface import Model
from crosscheck.registry import model_names
from tests.any_arms import any_links, planetary_joints
from tests.mixed_arms import NONE, arm_of
from tests.one_stage import free_model, plain_mesh, sine

DISPLACEMENT_M, ANGLE = 1e-4, 1e-3  # forces of teeth without play are linear in either
# A difference keeps the rounding of arcs of 0.1 m over 1e-4 m, and a mode up to 1e3 of it more.
ROUNDING = 1e-9
ANGLE_AT_START = 0.4

stiffnesses = st.floats(0, 1).map(lambda power: 1e6 * 500**power)


@dataclass(frozen=True)
class Stage:
    """Equivalent masses [kg] of sun, one planet and carrier; mean stiffnesses [N/m] of a planet."""

    planets: int
    sun: float
    planet: float
    carrier: float
    sun_stiffness: float
    ring_stiffness: float

    def squares(self) -> np.ndarray:
        """w^2 [1/s^2], ascending, (N + 2,)."""
        N, k_s, k_r = self.planets, self.sun_stiffness, self.ring_stiffness
        m_s, m_p, m_c = self.sun, self.planet, self.carrier
        # Of w^4, -w^2 and 1, for modes in which planets move alike.
        leading = m_p * m_c * m_s
        middle = N * k_s * m_p * m_c + (k_r + k_s) * m_c * m_s + N * (k_r + k_s) * m_p * m_s
        last = N * k_r * k_s * (N * m_p + m_c + 4 * m_s)
        # The larger root without cancellation, the smaller by their product.
        larger = (middle + math.sqrt(middle**2 - 4 * leading * last)) / (2 * leading)
        roots = [0.0, last / leading / larger, larger]
        return np.sort([*roots, *[(k_s + k_r) / m_p] * (N - 1)])


@st.composite
def one_stage_arms(draw: st.DrawFn) -> Arm:
    """Arms of one geared joint without play, error, damping or weight, stiffness constant."""
    joint = draw(planetary_joints())
    for side in ("sun_mesh", "ring_mesh"):
        joint[side] = plain_mesh(sine(draw(stiffnesses), 0.0), draw(st.floats(-3, 3)))
    links, payload = [draw(any_links())], draw(st.integers(0, 15))
    return arm_of(joint, links=links, payload_kg=payload, gravity=NONE)


def stage_of(arm: Arm) -> Stage:
    """The arm's only stage, the carrier with all that turns with it."""
    joint, link = arm.joints[0], arm.links[0]
    assert isinstance(joint, Planetary)
    radii = Radii.of(joint)
    mass, inertia = link.mass_kg, link.inertia_kg_m2
    if mass is None or inertia is None:
        mass = link.cross_section_m2 * link.density_kg_per_m3 * link.length_m
        inertia = mass * link.length_m**2 / 12
    carried = (
        joint.planet_count * joint.planet_mass_kg * radii.carrier**2
        + inertia
        + mass * link.com_m**2
        + arm.payload_mass_kg * link.length_m**2
    )
    own = {
        part: getattr(joint, f"{part}_equivalent_mass_kg")
        or getattr(joint, f"{part}_inertia_kg_m2") / radius**2
        for part, radius in (("sun", radii.sun), ("planet", radii.planet), ("carrier", radii.u_c))
    }
    return Stage(
        joint.planet_count,
        own["sun"],
        own["planet"],
        own["carrier"] + carried / radii.u_c**2,
        joint.sun_mesh.planet_mesh(0).stiffness.mean_N_per_m,
        joint.ring_mesh.planet_mesh(0).stiffness.mean_N_per_m,
    )


@dataclass(frozen=True)
class Radii:
    """Base radii of sun and planet, of the planets' centres, and what makes u_c [m]."""

    sun: float
    planet: float
    carrier: float
    u_c: float

    @classmethod
    def of(cls, joint: Planetary) -> Self:
        """From module, teeth and pressure angle."""
        half, cosine = joint.module_m / 2, math.cos(math.radians(joint.pressure_angle_deg))
        sun, planet = half * joint.sun_teeth, half * joint.planet_teeth
        return cls(sun * cosine, planet * cosine, sun + planet, (sun + planet) * cosine)


def start_pose(model: Model) -> np.ndarray:
    """No tooth loaded, the arm at an angle."""
    return np.where(model.layout.angular, ANGLE_AT_START, 0.0)


def stiffness_matrix(model: Model) -> np.ndarray:
    """Slope of the forces at rest, (n, n), by central differences, its sign turned."""
    q, rest = start_pose(model), np.zeros(len(model.layout))
    columns = []
    for place, angular in enumerate(model.layout.angular):
        step = np.zeros(q.size)
        step[place] = ANGLE if angular else DISPLACEMENT_M
        forces = [model.generalized_force(0.0, q + way * step, rest) for way in (1, -1)]
        columns.append((forces[1] - forces[0]) / (2 * step[place]))
    return np.array(columns).T


@pytest.mark.parametrize("name", model_names("geared"))
@settings(max_examples=15)
@given(one_stage_arms())
def test_frequencies_are_those_in_print(name, arm):
    model = free_model(name, arm)
    mass = model.mass_matrix(start_pose(model))
    found = np.abs(eigh(stiffness_matrix(model), mass, eigvals_only=True))
    expected = stage_of(arm).squares()
    assert found[0] <= ROUNDING * expected[1]
    assert found[1:] == pytest.approx(expected[1:], rel=ROUNDING)
