"""H6: the linearised controller and the verdicts drawn from it."""

import numpy as np
import pytest
import xarray as xr

from crosscheck.analytic.kernel.batch import Batch
from crosscheck.analytic.kernel.equations import TermEquations
from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.stability import contact_eigenvalues
from crosscheck.audit.experiments.samples import Sample
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.hypotheses import controller
from crosscheck.audit.hypotheses.controller import FlutterEvidence
from crosscheck.audit.hypotheses.evidence import flutter, linear_limits
from crosscheck.audit.hypotheses.evidence.flutter import (
    VIBRATES,
    DriveHandover,
    Flutter,
    FlutterSetting,
    VibrationAfterHandover,
)
from crosscheck.audit.hypotheses.evidence.linear_limits import (
    SUN,
    Point,
    Threshold,
    is_growth_predicted,
)
from crosscheck.audit.phase.runs import ContinuedModel
from crosscheck.models.experiment.drive import drive_data
from crosscheck.registry import build


@pytest.mark.parametrize("zeta", [0.003, 0.05])
def test_the_link_controller_is_that_of_the_stability_module(zeta):
    model = PhysicalModel(*Variant(zeta=zeta).case())
    pose = np.array([0, 0, 0, 0, 0, 0.5])
    poles = contact_eigenvalues(model.terms, model.gears, model.drive, pose, model.gears.k_m)
    rate, frequency = linear_limits.growth(Point(elbow_rad=0.5), zeta)
    fast = poles.imag > linear_limits.SLOWEST_MESH_MODE
    worst = poles[np.argmax(np.where(fast, poles.real, -np.inf))]
    assert rate == pytest.approx(worst.real, rel=1e-6)
    assert frequency == pytest.approx(worst.imag / (2 * np.pi), rel=1e-9)


def test_growth_changes_sign_at_the_threshold():
    edge = linear_limits.find_threshold(Point())
    below, above = (linear_limits.growth(Point(), part * edge)[0] for part in (0.99, 1.01))
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
    model = PhysicalModel(*Variant().case())
    for matrix in linear_limits.feedback(model, (1000.0, 400.0), SUN):
        np.testing.assert_allclose(matrix, matrix.T)
        assert np.linalg.eigvalsh(matrix).max() < 1e-9 * np.abs(matrix).max()
    assert linear_limits.find_threshold(Point(elbow_rad=elbow, sensed=SUN)) == 0


def _cell(setting: FlutterSetting, vibrating: int, of: int = 32) -> Flutter:
    sizes = [0.5 * VIBRATES] * (of - vibrating) + [2 * VIBRATES] * vibrating
    return Flutter(setting, tuple(sizes), None)


@pytest.mark.parametrize(
    ("with_error", "without", "independent"),
    [(32, 31, True), (32, 0, False), (0, 0, False), (16, 32, False)],
)
def test_independent_of_error(with_error, without, independent):
    counts = {5.0: with_error, 0.0: without}
    cells = [_cell(FlutterSetting("always", 0.003, error), n) for error, n in counts.items()]
    assert controller.is_independent_of_error(FlutterEvidence(tuple(cells))) is independent


@pytest.mark.parametrize(
    ("bare", "link", "sun", "feeds"),
    [(0, 20.0, 0.1, True), (1, 20.0, 0.1, False), (0, 20.0, 1.1, False), (0, 0.9, 0.1, None)],
)
def test_what_lives_on_the_feedback(bare, link, sun, feeds):
    """None: where nothing vibrated, nothing was handed over."""
    cell = _cell(FlutterSetting("contact", 0.006, played_back=True), bare)
    handed = (
        (
            FlutterSetting("contact", 0.006),
            VibrationAfterHandover([link, 0.0], [0.1, 0.0], [sun, 0.0]),
        ),
    )
    assert controller.is_driven_by_feedback(FlutterEvidence((cell,), handed)) is feeds


def test_a_diverged_start_vibrates_and_one_that_ends_early_says_nothing():
    sample = Sample(
        {"vibration": np.array([0.1, np.nan, np.nan]), "frequency_Hz": np.array([9.0, 0.0, 0.0])},
        np.array([False, True, False]),
    )
    found = flutter.summarize_flutter(FlutterSetting("always", 0.003), sample)
    assert found.sizes == (0.1, np.inf)
    assert found.share is not None
    assert found.share.yes == 1


SEEDS = (1, 2)


@pytest.mark.slow
def test_the_vibration_of_undamped_play_dies_without_feedback():
    """H6's switch in small: a run that goes on with another controller."""
    found = DriveHandover(FlutterSetting("contact", 0.006).variant(), SEEDS).answer()
    assert max(found.torque) < VIBRATES < max(found.link)
    assert max(found.sun) < VIBRATES


def test_a_sensor_on_the_links_is_the_drives_own_feedback():
    """The controller as a sensor on the link gives the run that the PD drive gives."""
    case = Variant(zeta=0.05, planets="free").case()
    model = PhysicalModel(*case)
    link = np.eye(len(model.layout))[:, model.layout.theta]
    parts = model.arm, model.layout, model.gears, model.drive, model.terms
    runs = []
    for equations in (TermEquations(*parts), TermEquations(*parts, sensor=link)):
        run = ContinuedModel(case, *model.start(), equations)
        runs.append(Batch([run], lanes=1).advance(5, 100).q)
    np.testing.assert_array_equal(*runs)
    assert np.abs(runs[0] - runs[0][0]).max() > 0


def test_a_torque_that_is_played_back_is_the_rigid_arms():
    variant = FlutterSetting("contact", 0.01).variant()
    case = flutter.replace_drive_by_rigid_torque(variant.case(), variant)
    rigid = build("analytic:coupled", case.arm, variant.case().scenario).simulate()
    drive = drive_data(case.scenario, 2)
    time, torque = rigid["time"].values, rigid["torque"].values
    table = np.array([np.interp(time, drive.table_time, row) for row in drive.table_torque]).T
    # A straight line over h misses T by T'' h^2 / 8; T'' by differences of the records, a tenth
    # more for their own error.
    curvature = np.abs(np.diff(torque, 2, axis=0)).max() / (time[1] - time[0]) ** 2
    np.testing.assert_allclose(table, torque, atol=1.1 * curvature * flutter.TABLE_S**2 / 8)
    assert np.abs(torque).max() > 100


@pytest.mark.parametrize(("measured", "agrees"), [(10.9, True), (11.1, False), (8.9, False)])
def test_growth_agrees_within_a_tenth(measured, agrees):
    assert is_growth_predicted(measured, 10.0) is agrees


@pytest.mark.parametrize(("sun", "cured"), [(0.0, True), (0.001, False)])
def test_cured_at_the_sun(sun, cured):
    survey = [
        Threshold(Point(), 0.005, 1500.0, 1.0, 0.0),
        Threshold(Point(sensed=SUN), sun, 1500.0, 1.0, 0.0),
    ]
    assert linear_limits.is_cured_at_sun(survey) is cured


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
    measured = linear_limits.growth_rate(run)
    assert measured["growth_per_s"] == pytest.approx(20, rel=0.02)
    assert measured["elbow_rad"] == pytest.approx(0.3)
