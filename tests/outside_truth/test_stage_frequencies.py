"""Natural frequencies of one stage with free planets, ring held and carrier free, in closed form.

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
from typing import Any, Self

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.interface import Model
from crosscheck.registry import model_names
from tests.any_arms import around, bodies, planetary_joints, rods
from tests.mixed_arms import NONE, arm_of
from tests.one_stage import free_model, plain_mesh, sine

DISPLACEMENT_M, ANGLE = 1e-4, 1e-3  # forces of teeth without play are linear in either
# A difference keeps the rounding of arcs of 0.1 m over 1e-4 m, and a mode up to 1e3 of it more.
ROUNDING = 1e-9
ANGLE_AT_START = 0.4

stiffnesses = st.floats(0, 1).map(lambda power: 1e6 * 500**power)


@dataclass(frozen=True)
class Stage:
    """Equivalent masses [kg] of sun, one planet and carrier; mean stiffnesses [N/m] by planet."""

    sun: float
    planet: float
    carrier: float
    sun_stiffness: tuple[float, ...]
    ring_stiffness: tuple[float, ...]

    @property
    def planets(self) -> int:
        """How many."""
        return len(self.sun_stiffness)

    def matrices(self) -> tuple[np.ndarray, np.ndarray]:
        """Mass and stiffness matrix over u = (sun, carrier, planets), (N + 2, N + 2) each."""
        mass = np.diag([self.sun, self.carrier, *[self.planet] * self.planets])
        stiffness = np.zeros_like(mass)
        springs = zip(self.sun_stiffness, self.ring_stiffness, strict=True)
        for number, (of_sun, of_ring) in enumerate(springs):
            own = np.eye(self.planets)[number]
            for k, row in ((of_sun, [1, -1, *-own]), (of_ring, [0, -1, *own])):
                stiffness += k * np.outer(row, row)
        return mass, stiffness

    def squares(self) -> np.ndarray:
        """w^2 [1/s^2] of planets alike, ascending, (N + 2,): the closed form."""
        N, k_s, k_r = self.planets, self.sun_stiffness[0], self.ring_stiffness[0]
        m_s, m_p, m_c = self.sun, self.planet, self.carrier
        leading, middle, last = quadratic(N, m_s, m_p, m_c, k_s, k_r)
        # The larger root without cancellation, the smaller by their product.
        larger = (-middle + math.sqrt(middle**2 - 4 * leading * last)) / (2 * leading)
        roots = [0.0, last / leading / larger, larger]
        return np.sort([*roots, *[(k_s + k_r) / m_p] * (N - 1)])


def quadratic(N: Any, m_s: Any, m_p: Any, m_c: Any, k_s: Any, k_r: Any) -> tuple[Any, Any, Any]:
    """Coefficients of w^4, w^2 and 1, for modes in which planets move alike."""
    middle = N * k_s * m_p * m_c + (k_r + k_s) * m_c * m_s + N * (k_r + k_s) * m_p * m_s
    return m_p * m_c * m_s, -middle, N * k_r * k_s * (N * m_p + m_c + 4 * m_s)


@pytest.mark.parametrize("planets", range(2, 7))
def test_determinant_falls_into_these_factors(planets):
    """det(K - w^2 M) is -w^2 times the others, whatever the masses and stiffnesses.

    Both are polynomials of degree 16 or less, and equal where all are whole numbers up to a million
    that nobody chose: where two differ, a draw in some 10^5 finds them equal.
    """
    draw = np.random.default_rng(planets)
    m_s, m_p, m_c, k_s, k_r, square = map(sympy.Integer, draw.integers(1, 10**6, 6).tolist())
    u_s, u_c, *u_p = u = sympy.symbols(f"u:{planets + 2}")
    kinetic = m_s * u_s**2 + m_c * u_c**2 + m_p * sum(p**2 for p in u_p)
    potential = sum(k_s * (u_s - p - u_c) ** 2 + k_r * (p - u_c) ** 2 for p in u_p)
    pencil = sympy.hessian(potential - square * kinetic, u) / 2
    a, b, c = quadratic(planets, m_s, m_p, m_c, k_s, k_r)
    alike = a * square**2 + b * square + c
    factors = -square * (k_s + k_r - m_p * square) ** (planets - 1) * alike
    assert pencil.det(method="bareiss") == factors


stages = st.builds(
    lambda masses, planets, sun, ring: Stage(*masses, (sun,) * planets, (ring,) * planets),
    st.tuples(around(0.5), around(0.7), around(50.0, 10.0)),
    st.integers(2, 6),
    stiffnesses,
    stiffnesses,
)


@given(stages)
def test_plain_matrices_have_these_frequencies(stage):
    mass, stiffness = stage.matrices()
    assert_same(np.abs(eigh(stiffness, mass, eigvals_only=True)), stage.squares())


@st.composite
def one_stage_arms(draw: st.DrawFn) -> Arm:
    """Arms of one geared joint without play, error, damping or weight, stiffness constant."""
    joint = draw(planetary_joints())
    count = joint["planet_count"]
    for side in ("sun_mesh", "ring_mesh"):
        means = st.lists(stiffnesses, min_size=count, max_size=count)
        laws = means.map(lambda k: [sine(mean, 0.0) for mean in k])
        joint[side] = plain_mesh(draw(laws), draw(st.floats(-3, 3)))
    links, payload = [draw(rods() | bodies())], draw(st.just(0.0) | around(5.0))
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
    planets = range(joint.planet_count)
    return Stage(
        own["sun"],
        own["planet"],
        own["carrier"] + carried / radii.u_c**2,
        tuple(joint.sun_mesh.planet_mesh(n).stiffness.mean_N_per_m for n in planets),
        tuple(joint.ring_mesh.planet_mesh(n).stiffness.mean_N_per_m for n in planets),
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


def of_gears(joint: Planetary) -> np.ndarray:
    """u = (sun, carrier, planets) over the free coordinates x_s, x_pr of each planet and theta.

    x_s = u_s - 2 u_c, x_pr = u_p - u_c, u_c = r_cp theta.
    """
    count = joint.planet_count
    moved = np.zeros((count + 2, count + 2))
    moved[0, 0] = 1.0
    moved[2:, 1:-1] = np.eye(count)
    moved[:, -1] = Radii.of(joint).u_c * np.array([2.0, 1.0, *[1.0] * count])
    return moved


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


def assert_same(found: np.ndarray, expected: np.ndarray) -> None:
    """Squares of frequencies, ascending, the first of them zero."""
    assert found[0] <= ROUNDING * expected[1]
    assert found[1:] == pytest.approx(expected[1:], rel=ROUNDING)


def assert_close(found: np.ndarray, inner: np.ndarray, moved: np.ndarray) -> None:
    """A matrix over free coordinates against one over u; each entry by what it is summed from."""
    expected = moved.T @ inner @ moved
    size = np.sqrt(np.diag(np.abs(moved).T @ np.abs(inner) @ np.abs(moved)))
    assert (np.abs(found - expected) <= ROUNDING * np.outer(size, size)).all()


every_geared_model = pytest.mark.parametrize("name", model_names("geared"))


@every_geared_model
@settings(max_examples=15)
@given(one_stage_arms())
def test_matrices_of_planets_unlike(name, arm):
    model, moved = free_model(name, arm), of_gears(arm.joints[0])
    mass, stiffness = stage_of(arm).matrices()
    assert_close(model.mass_matrix(start_pose(model)), mass, moved)
    assert_close(stiffness_matrix(model), stiffness, moved)
