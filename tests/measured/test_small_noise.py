"""Records of next to no noise: what a filter or friction's sign does would be seen in estimates."""

import numpy as np
import pytest

from crosscheck.identification import compare, sampling
from crosscheck.identification.sampling import space_signals
from crosscheck.recordings.record import Record
from tests.measured import robots
from tests.measured.robots import COULOMB, RATIO, ROTOR, STEP, VISCOUS, arm, first_side, recording

BAND = 1.5  # [Hz]


def find_misses(seeds: int) -> np.ndarray:
    """Errors of friction and rotor in their standard errors (seeds, 7)."""
    right = {f"coulomb of j{n}": value for n, value in enumerate(COULOMB, 1)}
    right |= {f"viscous of j{n}": value for n, value in enumerate(VISCOUS, 1)}
    right["armature of j3"] = RATIO**2 * ROTOR
    misses = []
    for seed in range(seeds):
        side = first_side(arm(), recording(arm(), "armature", seed))
        by_name = {each.term.name: each for each in side.estimates}
        misses.append([(by_name[n].value - value) / by_name[n].error for n, value in right.items()])
    return np.array(misses)


@pytest.fixture
def quiet(monkeypatch):
    """Recordings of a twentieth of the noise."""
    monkeypatch.setattr(robots, "TORQUE_NOISE", 0.01)
    monkeypatch.setattr(robots, "POSITION_NOISE", 1e-7)


def test_estimates_miss_by_their_standard_errors(quiet):
    """28 misses of Student's distribution have a mean square of 1.1 +- 0.3."""
    assert np.sqrt((find_misses(4) ** 2).mean()) < 1.5


def test_a_sign_that_is_cut_where_joints_turn_slowly_is_seen(quiet, monkeypatch):
    monkeypatch.setattr(sampling, "RAMP", 0.3)
    assert np.sqrt((find_misses(1) ** 2).mean()) > 1.5


def test_columns_hold_all_of_friction_and_of_inertia():
    """A sign at the rows of its torque; an acceleration at half of the motion's band."""
    time = np.arange(10_000)[:, None] * STEP
    rate = 2 * np.pi * (BAND * sampling.MOTION_BAND / 2)
    signs = -np.sign(np.sin(rate * time + 1e-3))
    given = space_signals(Record("made", time[:, 0], np.cos(rate * time + 1e-3), signs), signs)
    rows = sampling.sample([given], np.zeros((0, 1)), BAND)
    assert np.abs(rows.torque - rows.direction).max() < 1e-5
    size = np.median(np.hypot(rows.motion.a, rate * rows.motion.v))
    assert size == pytest.approx(rate**2, rel=1e-4)


def sample_turns(noise: float, power: int = 0) -> sampling.BandSample:
    """Rows of a joint that turns at the same places of a step again and again.

    Its torque is its friction, and so high a power of its position.
    """
    time = np.arange(20_000)[:, None] * STEP
    rates, phases = 2 * np.pi * np.array([0.4, 1.0, 2.5]), np.array([0.1, 1.0, 2.0])
    angles = np.sin(rates * time + phases).sum(axis=1, keepdims=True) / 3
    speeds = (rates * np.cos(rates * time + phases)).sum(axis=1, keepdims=True) / 3
    torque = np.sign(speeds) + (angles**power if power else 0.0)
    given = angles + noise * np.random.default_rng(0).standard_normal(angles.shape)
    signals = space_signals(Record("made", time[:, 0], given, torque), torque)
    return sampling.sample([signals], np.zeros((0, 1)), BAND)


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_friction_turns_with_its_joint_in_noise(noise):
    """No row near a turn has the other sign than its torque: such errors would come again."""
    rows = sample_turns(noise)
    assert np.abs(rows.torque - rows.direction).max() < 1e-7


def test_a_line_over_no_turn_is_none(monkeypatch):
    """Where no row counts as hidden, noise turns friction at other rows than the joint."""
    monkeypatch.setattr(sampling, "UNSURE", 0.0)
    rows = sample_turns(1e-3)
    assert np.abs(rows.torque - rows.direction).max() > 1e-3


def test_products_of_a_motion_hold_what_torques_do():
    """Friction and a fifth power, which reaches beyond the band of motions, without noise."""
    rows = sample_turns(0.0, 5)
    fifth = rows.filter(rows.motion.q**5)
    assert np.abs(rows.torque - rows.direction - fifth).max() < 1e-4


@pytest.mark.parametrize(("wider", "is_explained"), [(4.0, True), (1.0, False)])
def test_a_band_amid_the_motion_leaves_noise_alone(quiet, monkeypatch, wider, is_explained):
    """Of white noise the share of the band; filtered motions alone would not explain torques."""
    monkeypatch.setattr(compare, "choose_bandwidth", lambda *given: BAND)
    monkeypatch.setattr(sampling, "MOTION_BAND", wider)
    side = first_side(arm(), recording(arm(), "armature", seconds=20.0, friction=0.0))
    noise = robots.TORQUE_NOISE * np.sqrt(2 * BAND * robots.STEP)
    assert bool((side.steps[-1].rms < 1.2 * noise).all()) == is_explained


@pytest.mark.parametrize("rows", [160, 161, 1000])
def test_half_of_the_least_band_has_rows(rows):
    """The shortest recording that rows resolve has some between its edges, so has a longer one."""
    time = STEP * np.arange(rows + 1.0)[:, None]
    given = Record("made", time[:, 0], np.sin(2 * np.pi * time), np.cos(time))
    least = sampling.lowest_bandwidth([given])
    assert least <= sampling.highest_bandwidth([given]) * (1 + 1e-12)
    signals = space_signals(given, given.motor_torque)
    found = sampling.sample([signals], np.zeros((0, 1)), least / 2)
    assert len(found.torque) >= sampling.LEAST_PERIODS / 2
