"""H6: the linearised controller and the verdicts drawn from it."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from analytic.model import PhysicalModel
from analytic.stability import contact_eigenvalues
from crosscheck.paper.hypotheses import controller, feedback
from crosscheck.paper.hypotheses.controller_records import Flutter, Threshold, growth_agrees
from crosscheck.paper.hypotheses.feedback import SUN, Point
from crosscheck.studies.study import Variant


@pytest.mark.parametrize("zeta", [0.003, 0.05])
def test_the_link_controller_is_that_of_the_stability_module(zeta):
    model = PhysicalModel(*Variant(zeta=zeta).case())
    pose = np.array([0, 0, 0, 0, 0, 0.5])
    poles = contact_eigenvalues(model.terms, model.gears, model.drive, pose, model.gears.k_m)
    rate, frequency = feedback.growth(Point(elbow_rad=0.5), zeta)
    worst = poles[np.argmax(np.where(poles.imag > feedback.SLOWEST_MESH_MODE, poles.real, -np.inf))]
    assert rate == pytest.approx(worst.real, rel=1e-6)
    assert frequency == pytest.approx(worst.imag / (2 * np.pi), rel=1e-9)


def test_growth_changes_sign_at_the_threshold():
    edge = feedback.threshold(Point())
    assert feedback.growth(Point(), 0.99 * edge)[0] > 0 > feedback.growth(Point(), 1.01 * edge)[0]


def test_the_sun_feels_torque_and_angle_through_one_lever():
    """theta_s / n by the paper's geometry: drive_map is its gradient."""
    model = PhysicalModel(*Variant().case())
    r_s, r_p = 0.0135 * 3 * np.cos(np.radians(24.6)), 0.018 * 3 * np.cos(np.radians(24.6))
    n = 99 / 27 + 1
    gradient = np.array([1, 1, 2 * (r_s + r_p)]) / r_s / n
    np.testing.assert_allclose(model.terms.drive_map[:3, 0], gradient, rtol=1e-12)


@pytest.mark.parametrize("elbow", [0.0, 1.0, 3.0])
def test_feedback_at_the_sun_only_stores_and_dissipates(elbow):
    model = PhysicalModel(*Variant().case())
    for matrix in feedback.feedback(model, (1000.0, 400.0), SUN):
        np.testing.assert_allclose(matrix, matrix.T)
        assert np.linalg.eigvalsh(matrix).max() < 1e-9 * np.abs(matrix).max()
    assert feedback.threshold(Point(elbow_rad=elbow, sensed=SUN)) == 0


def _cells(with_error: bool, without: bool) -> list[Flutter]:
    return [
        Flutter("always", 0.003, E, 2.0 if flutters else 0.5)
        for E, flutters in ((5e-6, with_error), (0.0, without))
    ]


@pytest.mark.parametrize(
    ("with_error", "without", "independent"),
    [(True, True, True), (True, False, False), (False, False, False)],
)
def test_independent_of_error(with_error, without, independent):
    assert controller.independent_of_error(_cells(with_error, without)) is independent


@pytest.mark.parametrize(("size", "goes_on"), [(1.1, True), (0.9, False), (None, True)])
def test_flutters_on_both_sides(size, goes_on):
    diverged = 1.0 if size is None else None
    assert Flutter("always", 0.003, 0.0, size, diverged_s=diverged).flutters is goes_on


@pytest.mark.parametrize(("measured", "agrees"), [(10.9, True), (11.1, False), (8.9, False)])
def test_growth_agrees_within_a_tenth(measured, agrees):
    assert growth_agrees(measured, 10.0) is agrees


@pytest.mark.parametrize(("sun", "cured"), [(0.0, True), (0.001, False)])
def test_cured_at_the_sun(sun, cured):
    survey = [
        Threshold(Point(), 0.005, 1500.0, 1.0, 0.0),
        Threshold(Point(sensed=SUN), sun, 1500.0, 1.0, 0.0),
    ]
    assert controller.cured_at_the_sun(survey) is cured


def test_growth_rate_of_a_known_vibration():
    time = np.arange(0, 0.45, 2e-5)
    x = 1e-6 + 1e-7 * np.exp(20 * time) * np.sin(2 * np.pi * 1700 * time)
    run = xr.Dataset(
        {
            "x_sp": (("time", "joint", "planet"), np.tile(x[:, None, None], (1, 2, 1))),
            "theta": (("time", "joint"), np.full((time.size, 2), 0.3)),
        },
        {"time": time},
    )
    measured = controller.growth_rate(run)
    assert measured["growth_per_s"] == pytest.approx(20, rel=0.02)
    assert measured["elbow_rad"] == pytest.approx(0.3)
