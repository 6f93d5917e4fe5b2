"""The linearised controller: thresholds of its instability, beside simulated growth."""

import numpy as np
import pytest

from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.variant import Variant, simulate
from crosscheck.audit.findings import linear_limits
from crosscheck.audit.findings.linear_limits import SUN, Point


def test_growth_changes_sign_at_the_threshold():
    edge = linear_limits.find_threshold(Point())
    below, above = (linear_limits.compute_growth(Point(), part * edge) for part in (0.99, 1.01))
    assert below > 0 > above


def test_the_sun_feels_torque_and_angle_through_one_lever():
    """theta_s / n by the paper's geometry: drive_map is its gradient."""
    model = PhysicalModel(*Variant().case())
    r_s, r_p = 0.0135 * 3 * np.cos(np.radians(24.6)), 0.018 * 3 * np.cos(np.radians(24.6))
    n = 99 / 27 + 1
    gradient = np.array([1, 1, 2 * (r_s + r_p)]) / r_s / n
    np.testing.assert_allclose(model.terms.drive_map[:3, 0], gradient, rtol=1e-12)


@pytest.mark.parametrize("elbow", [0.0, 1.0, 3.0])
def test_feedback_at_the_sun_only_stores_and_dissipates(elbow):
    assert linear_limits.find_threshold(Point(elbow_rad=elbow, sensed=SUN)) == 0
    assert linear_limits.find_threshold(Point(elbow_rad=elbow)) > 0


def test_a_vibration_grows_as_the_eigenvalues_say():
    """The PD run without backlash, tooth error and stiffness variation, whose peaks are counted."""
    names = ("backlash_m", "tooth_error_m", "stiffness.amplitude_N_per_m")
    settings = tuple(f"arm.joints.*.*_mesh.{name}=0.0" for name in names)
    run = simulate(Variant(zeta=0.003, duration_s=0.45, settings=settings))
    time, x, width = run["time"].values, run["x_sp"].values[:, 0, 0], 250  # 5 ms
    vibration = np.abs(x - np.convolve(x, np.ones(width) / width, mode="same"))
    part = slice(5000, 20000)  # 0.1 to 0.4 s
    peaks = vibration[part].reshape(-1, width).max(axis=1)
    measured = np.polyfit(time[part].reshape(-1, width).mean(axis=1), np.log(peaks), 1)[0]
    pose = float(run["theta"].values[part, 1].mean())
    # The frozen eigenvalues at the mean pose stand for those along it.
    foretold = linear_limits.compute_growth(Point(elbow_rad=pose), 0.003)
    assert measured == pytest.approx(foretold, rel=0.1)


@pytest.mark.parametrize(("sun", "cured"), [(0.0, True), (0.001, False)])
def test_cured_at_the_sun(sun, cured):
    survey = {Point(): 0.005, Point(sensed=SUN): sun}
    assert linear_limits.is_cured_at_sun(survey) is cured
