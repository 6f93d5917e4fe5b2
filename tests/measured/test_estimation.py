"""Rows, bands and intervals of estimates from torques: closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from crosscheck.identification import estimation
from crosscheck.identification.bandwidth import choose_bandwidth, measure_error
from crosscheck.identification.estimation import fit_linear, fit_part, joint_rms
from crosscheck.identification.sampling import space_signals
from crosscheck.recordings.record import Record

ROWS = 600


def test_an_interval_is_of_students_distribution():
    """One block less than there are, twice, is what its degrees of freedom are."""
    from scipy.stats import t  # slow to import, in every process that collects tests

    torque = 3.0 + np.random.default_rng(0).standard_normal((ROWS, 1))
    shown = np.ones((ROWS, 1), dtype=bool)
    fit = fit_linear(np.ones((ROWS, 1, 1)), torque, shown, (0, ROWS))
    expected = t.ppf(0.975, 2 * (len(fit.edges) - 2)) * fit.errors
    assert fit.half_widths == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("error", "chosen"), [(0.9, 4.0), (0.99, 2.0)])
def test_a_band_ends_where_errors_fall_no_more(error, chosen):
    def measure(bandwidth: float) -> float:
        steps = round(2 * np.log2(bandwidth))
        further = max(steps - 2, 0)
        return 0.8**steps * (error / 0.8) ** further

    found = choose_bandwidth(measure, 1.0, 4.1)
    assert found == pytest.approx(chosen)


def test_errors_of_a_constant_in_noise_that_is_alike():
    """A mean of every row's noise and of k rows': closed forms, by 200 draws of each."""
    for alike in (1, 6):
        rng, errors, means = np.random.default_rng(alike), [], []
        for _ in range(200):
            noise = np.convolve(rng.standard_normal(ROWS + alike - 1), np.ones(alike), "valid")
            fit = fit_linear(
                np.ones((ROWS, 1, 1)), noise[:, None], np.ones((ROWS, 1), bool), (0, ROWS)
            )
            errors.append(fit.errors[0])
            means.append(fit.values[0])
        right = alike / np.sqrt(ROWS)
        assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(right, rel=0.15)
        assert np.std(means) == pytest.approx(right, rel=0.15)


def test_no_block_spans_two_recordings():
    noise = np.random.default_rng(0).normal(size=(1004, 1))
    assert {0, 1000, 1004} <= set(estimation.choose_blocks(noise, [0, 1000, 1004]))


def test_errors_that_joints_share_do_not_cancel():
    """A constant of two joints that have the same noise is as uncertain as one joint's."""
    noise = np.random.default_rng(0).standard_normal((ROWS, 1)) * np.ones(2)
    fit = fit_linear(np.ones((ROWS, 2, 1)), noise, np.ones((ROWS, 2), bool), (0, ROWS))
    assert fit.pooled_errors[0] == pytest.approx(1 / np.sqrt(ROWS), rel=0.15)
    for errors, mean in (([0.0, 2.0, 8.0], 4.0), ([0.0], 1.0)):  # those of zeros count for none
        assert measure_error(replace(fit, pooled_errors=np.array(errors))) == pytest.approx(mean)


def test_a_part_that_is_all_of_a_fit_leaves_what_the_fit_leaves():
    """Joints with noise of 0.1 and 10; without its second column the first joint leaves more."""
    draw = np.random.default_rng(2)
    columns = draw.standard_normal((ROWS, 2, 2))
    noise = draw.standard_normal((ROWS, 2)) * [0.1, 10.0]
    torque, shown = columns @ [1.0, -2.0] + noise, np.ones((ROWS, 2), bool)
    full = fit_linear(columns, torque, shown, (0, ROWS))
    whole, part = (fit_part("", each, torque, full) for each in (columns, columns[:, :, :1]))
    assert whole.rms == pytest.approx(joint_rms(full.residual, shown.sum(axis=0)), rel=1e-6)
    assert whole.weighted == pytest.approx(1.0, rel=1e-6)
    assert part.weighted > part.rms[0] > 10 * whole.rms[0]


def test_uneven_times_are_made_even():
    """Rows 1 ms apart, give and take 0.4 ms, of one turn a second: lines are within 2e-5."""
    even = 1e-3 * np.arange(ROWS)
    jitter = 4e-4 * np.random.default_rng(1).uniform(-1, 1, ROWS)
    time = even + np.concatenate([[0.0], jitter[1:-1], [0.0]])
    position = np.sin(2 * np.pi * time)[:, None]
    recording = Record("made", time, position, position, None)
    signals = space_signals(recording, position)
    assert signals.step == pytest.approx(1e-3, rel=1e-12)
    assert len(signals.position) == ROWS
    expected = np.sin(2 * np.pi * even)
    assert np.abs(signals.position[:, 0] - expected).max() < 2e-5


def test_sizes_of_nothing_are_one():
    values = np.array([[3.0, 0.0, 0.0], [4.0, 0.0, 5.0]])
    assert joint_rms(values, np.array([2, 0, 1])) == pytest.approx([np.sqrt(12.5), 1.0, 5.0])
