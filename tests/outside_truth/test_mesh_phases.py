"""Phases of a stage's meshes against its gears drawn tooth by tooth, and against print.

On the carrier of a stage whose ring is held, the sun turns by z_r / z_s and the ring by -1 for each
radian of the carrier: z_r teeth pass either mesh in a turn, a mesh's phase is z_r theta + offset.
The sun drives with flanks that look forward, whose n-th comes to the pitch point of a planet at
psi where z_r theta = z_s psi - 2 pi n + const: later by z_s psi / 2 pi teeth, the offset of its
phase is -z_s psi. The ring's flanks that carry look forward too; the planet reaches one where
theta + psi = const + 2 pi n / z_r: offset +z_r psi, the same, as (z_s + z_r) psi is whole turns.
A planet touches the ring with the flank that looks back along its own turning, the sun with that
which looks the other way; half a turn apart these two are z_p / 2 pitches less a tooth's half pitch
apart. So ring mesh and sun mesh of one planet are in phase if z_p is odd, and half a cycle apart if
it is even.
"""

import cmath
import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.mesh import FROM_TEETH
from crosscheck.models.interface import Model
from crosscheck.registry import model_names
from tests.any_arms import any_gears, any_links, planetary_joints
from tests.involutes import TRAVEL, TURN, Stage, equal_places
from tests.loops import require_items
from tests.mixed_arms import NONE, arm_of
from tests.one_stage import free_model, plain_mesh, sine

LAW = sine(1e8, 3e7)
DISPLACEMENT_M = 1e-4
POSES = 8  # in a mesh cycle, that show the phase of a wave
DRAWN = 1e-6  # cycles: the point of a contact is found to 1e-7 of a module, a pitch is 3


def stage_of(gears: tuple[int, int, int], degrees: float, ring_at: float) -> Stage:
    """Teeth of sun and planet, and the number of planets, equally spaced."""
    sun, planet, count = gears
    return Stage(sun, planet, equal_places(count), math.radians(degrees), ring_at)


stages = st.builds(stage_of, any_gears(), st.floats(14.5, 28.0), st.floats(-3.0, 3.0))
sequential = planetary_joints().filter(lambda own: 2 * own["sun_teeth"] % own["planet_count"])


def sun_delay(sun_teeth: int, place: float) -> float:
    """Cycles by which the sun mesh of a planet there is later than that of a planet at zero."""
    return sun_teeth * place / TURN


def ring_delay(ring_teeth: int, place: float) -> float:
    """The same of the ring mesh."""
    return -ring_teeth * place / TURN


def off(cycles: float) -> float:
    """Distance from a whole number of cycles."""
    return abs(cycles - round(cycles))


def delays(stage: Stage) -> tuple[np.ndarray, np.ndarray]:
    """Cycles until the sun and the ring mesh of each planet pass, (planets,) each."""
    cycles = stage.ring.teeth / TURN
    return cycles * np.array(stage.sun_passages()), cycles * np.array(stage.ring_passages())


@settings(max_examples=25)
@given(stages)
def test_drawn_flanks_touch_on_the_line_of_action(stage):
    """Every planet as drawn fits sun and ring, and its contacts move as involutes' must."""
    sine, cosine = math.sin(stage.pressure_angle), math.cos(stage.pressure_angle)
    # Seen from the carrier, the sun's teeth go forward and the ring's back.
    sides = (
        (stage.sun_touch, stage.sun_passages(), stage.sun.pitch_radius, complex(sine, cosine)),
        (stage.ring_touch, stage.ring_passages(), stage.ring.pitch_radius, complex(sine, -cosine)),
    )
    for touch, passages, pitch_point, way in require_items(sides):
        for planet, passage in require_items(enumerate(passages)):
            for part in (-0.9 * TRAVEL, 0.0, 0.9 * TRAVEL):
                found = touch(planet, passage + part * stage.ring.pitch)
                base_pitches = part * math.pi * cosine
                assert abs(found.gap) < 1e-12
                assert abs(found.point - pitch_point - base_pitches * way) < 1e-5


def test_planets_that_do_not_assemble_are_seen_to_overlap():
    stage = stage_of((27, 36, 4), 24.6, 0.0)  # 126 teeth for four planets
    cycles = [stage.sun_touch(planet, 0.0).gap / stage.planet.pitch for planet in range(1, 4)]
    assert np.abs(cycles) == pytest.approx([0.5, 0.0, 0.5], abs=0.1)


@settings(max_examples=60)
@given(stages)
def test_phases_of_drawn_gears(stage):
    sun, ring = delays(stage)
    after_sun = 0.0 if stage.planet.teeth % 2 else 0.5  # cycles, of standard teeth
    for planet, place in require_items(enumerate(stage.places)):
        assert off(sun[planet] - sun[0] - sun_delay(stage.sun.teeth, place)) < DRAWN
        assert off(ring[planet] - ring[0] - ring_delay(stage.ring.teeth, place)) < DRAWN
        assert off(ring[planet] - sun[planet] - after_sun) < DRAWN


# Wind turbine stage of 21, 39 and 99 teeth: S. Shweiki, D. Mundo, J. Korta, P. Oranges, A. Palermo,
# "Investigation of mesh phasing in a planetary gear train using combined FE and multibody
# simulations", ISMA 2016, Tables 1 and 2, after R. G. Parker and J. Lin, J. Mech. Des. 126 (2004)
# 365-370. Planets at 42 and 84 parts of a turn over z_s + z_r = 120.
FITS_42 = tuple(TURN * ticks / 120 for ticks in (0, 42, 84))
PRINTED_SUN = (0.0, 0.35, 0.70)
PRINTED_RING = (0.2805, 0.9305, 0.5805)


def test_sun_phases_in_print():
    for place, printed in require_items(zip(FITS_42, PRINTED_SUN, strict=True)):
        assert off(sun_delay(21, place) - printed) < 1e-12
    for place in require_items(equal_places(3)):  # the row "in-phase": 40 and 80 parts
        assert off(sun_delay(21, place)) < 1e-12
        assert off(ring_delay(99, place)) < 1e-12


def test_ring_phases_in_print_have_the_wrong_sign():
    """Table 2 adds z_r psi / 2 pi where Eq. 8 of the same paper, and drawn gears, subtract it."""
    _, drawn = delays(Stage(21, 39, FITS_42, math.radians(20), 0.0))
    for place, printed, seen in zip(FITS_42, PRINTED_RING, drawn, strict=True):
        after_first = printed - PRINTED_RING[0]
        assert off(after_first + ring_delay(99, place)) < 1e-12
        assert off(seen - drawn[0] - ring_delay(99, place)) < DRAWN
    assert off(PRINTED_RING[1] - PRINTED_RING[0] - ring_delay(99, FITS_42[1])) > 0.29


# The same table's 0.2805 between sun and ring mesh cannot be followed: it hangs on the planet's
# tooth thickness, which is not printed. 39 standard teeth have none; theirs would be 0.22 or 0.78
# of a pitch thick.


@dataclass(frozen=True)
class Row:
    """Of a published table of four-planet stages, places of the planets in parts of a turn.

    across, upward, torque: sums over the ring meshes' first harmonics, by direction, to two digits.
    """

    sun: int
    ring: int
    ticks: tuple[int, int, int, int]
    across: float
    upward: float
    torque: float


# C. Glinsky, "Geometry / Planetary Gears", Drivetrain Hub notebooks, 2020, standard example: in
# phase, sequential, counter-phase, and planets diametrically opposed. The sums do not tell the
# phases' sign; its functions take that of the ring's as the sun's, against Parker and Lin.
TABLE = (
    Row(14, 42, (0, 14, 28, 42), 0.00, 0.0, 0.00),
    Row(15, 45, (0, 15, 30, 45), 1.00, 1.0, 0.00),
    Row(16, 48, (0, 16, 32, 48), 0.00, 0.0, 1.00),
    Row(17, 51, (0, 17, 34, 51), 1.00, 1.0, 0.00),
    Row(17, 49, (0, 17, 33, 50), 1.03, 1.0, 0.00),
    Row(50, 148, (0, 50, 99, 149), 0.00, 0.0, 0.39),
    Row(49, 149, (0, 50, 99, 149), 1.01, 1.0, 0.00),
)


@pytest.mark.parametrize("row", TABLE)
def test_sums_of_phases_in_print(row):
    places = [TURN * ticks / (row.sun + row.ring) for ticks in row.ticks]
    for cycles in (
        [sun_delay(row.sun, place) for place in places],
        [ring_delay(row.ring, place) for place in places],
    ):
        waves = [cmath.exp(1j * TURN * delay) for delay in cycles]
        pairs = list(zip(waves, places, strict=True))
        across = abs(sum(wave * math.cos(place) for wave, place in pairs)) / 2
        upward = abs(sum(wave * math.sin(place) for wave, place in pairs)) / 2
        assert across == pytest.approx(row.across, abs=0.0051)
        assert upward == pytest.approx(row.upward, abs=0.051)
        assert abs(sum(waves)) / 4 == pytest.approx(row.torque, abs=0.0051)


def test_helicopter_stage_in_print():
    """OH-58, 27 and 99 teeth: three planets are "nonsequential", four are "sequential".

    T. Krantz, "Gear tooth stress measurements of two helicopter planetary stages", NASA, 1992. Four
    do not fit at equal places; the nearest that fit are half a part of a turn off.
    """
    assert all(off(sun_delay(27, place)) < 1e-12 for place in equal_places(3))
    assert (27 + 99) % 4 == 2
    four = [sun_delay(27, TURN * ticks / 126) % 1 for ticks in (0, 32, 63, 95)]
    assert four == pytest.approx([0, 6 / 7, 1 / 2, 5 / 14])


@st.composite
def arms_by_teeth(draw: st.DrawFn) -> Arm:
    """One joint, its ring meshes in phase as the teeth say, its sun meshes too or as stated.

    By one number or by one for each planet. Planets one after the other by neither whole nor half
    cycles, which would hide a wrong sign.
    """
    joint, first = draw(sequential), draw(st.floats(-3, 3))
    places = equal_places(joint["planet_count"])
    listed = [first - TURN * sun_delay(joint["sun_teeth"], place) for place in places]
    sun = plain_mesh(LAW, draw(st.sampled_from([FROM_TEETH, first, listed])))
    joint |= {"sun_mesh": sun, "ring_mesh": plain_mesh(LAW, FROM_TEETH)}
    return arm_of(joint, links=[draw(any_links())], payload_kg=0.0, gravity=NONE)


def seen_phases(model: Model, loaded: str) -> np.ndarray:
    """Offsets [cycles] from z_r theta of the stiffness that loaded meshes show, (planets,).

    With the sun advanced alone its meshes are loaded, with the planets too those of the ring.
    """
    layout, joint = model.layout, model.arm.joints[0]
    of_planets, wave = layout.indices("x_pr"), np.zeros(joint.planet_count, dtype=complex)
    for pose in range(POSES):
        cycle, q = pose / POSES, np.zeros(len(layout))
        q[layout.indices("x_s")] = DISPLACEMENT_M
        q[of_planets] = DISPLACEMENT_M if loaded == "ring" else 0.0
        q[layout.theta] = TURN * cycle / joint.ring_teeth
        force = model.generalized_force(0.0, q, np.zeros_like(q))[of_planets]
        wave += (-force if loaded == "ring" else force) * cmath.exp(-1j * TURN * cycle)
    return np.angle(1j * wave) / TURN


@pytest.mark.parametrize("name", model_names("geared"))
@settings(max_examples=15)
@given(arms_by_teeth())
def test_models_meshes_are_in_phase_as_drawn(name, arm):
    joint, model = arm.joints[0], free_model(name, arm)
    degrees, gears = joint.pressure_angle_deg, (joint.sun_teeth, joint.planet_teeth)
    sun, ring = delays(stage_of((*gears, joint.planet_count), degrees, 0.0))
    stated = [joint.sun_mesh.planet_mesh(planet).phase_rad for planet in range(len(sun))]
    for planet, seen in require_items(enumerate(seen_phases(model, "sun"))):
        by_teeth = TURN * (sun[0] - sun[planet])
        assert off(seen - (by_teeth if stated[planet] is None else stated[planet]) / TURN) < DRAWN
    for planet, seen in require_items(enumerate(seen_phases(model, "ring"))):
        assert off(seen - (stated[0] or 0.0) / TURN + ring[planet] - sun[0]) < DRAWN
