"""A number on record may move by its tolerance and by no more."""

import pytest

from crosscheck.baseline.record import BoundedRecord, Extremes, SampledQuantity
from crosscheck.baseline.reduction import _measurement_bound, _round_up
from crosscheck.baseline.regression import _compare_numbers, _subject
from crosscheck.findings import ComparisonKey, Subject, make_measurement
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.loading import Case, load_arm, load_scenario
from crosscheck.runner.tasks import RunKey

TOLERANCE = 1e-6


@pytest.mark.parametrize(("share", "verdict"), [(0.99, "agree"), (1.01, "differ"), (9.0, "differ")])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_number_differs_just_beyond_its_tolerance(share, verdict, sign):
    record = BoundedRecord(unit="rad", tolerance=TOLERANCE, basis="as recorded")
    finding = _compare_numbers(
        _subject("finding", "made", None, "rad"), record, record, (0.0, sign * share * TOLERANCE)
    )
    assert (finding.verdict, finding.tolerance) == (verdict, TOLERANCE)
    for factor, verdict in ((98, "agree"), (102, "failed")):
        granted = BoundedRecord(unit="rad", tolerance=factor * TOLERANCE, basis="as recorded")
        compared = _compare_numbers(finding.about, granted, record, (0.5, 0.5))
        assert compared.verdict == verdict
    wide = BoundedRecord(unit="rad", tolerance=0.125, basis="as recorded")
    refused = _compare_numbers(finding.about, wide, record, (0.5, 0.5), "F_sp")
    assert "0.125 on record, 1e-06 now" in refused.note
    assert refused.note.endswith("F_sp: 0.5 -> 0.5")


@pytest.mark.parametrize("late_s", [-1.02e-9, -0.98e-9, 0.98e-9, 1.02e-9])
def test_a_run_on_record_ends_within_a_nanosecond_of_its_duration(late_s):
    given = {"unit": "rad", "tolerance": 1.0, "basis": "", "joints": (1,)}
    sampled = SampledQuantity(**given, rows=((0.0, 1.0), (1 + late_s, 1.0)))
    assert bool(sampled.find_row_fault(1.0)) == (abs(late_s) > 1e-9)
    extremes = Extremes(**given, rows=((1.0, 0.0, 0.5, 1.0, 1 + late_s),))
    assert bool(extremes.find_row_fault(1.0)) == (late_s > 1e-9)


def test_a_tip_may_move_by_every_joints_tolerance_along_the_links_behind_it():
    """Joints 1 to k turn link k: three links, two runs."""
    arm = load_arm("three-unlike")
    first, second, third = (link.length_m for link in arm.links)
    sides = {"a": 2e-9, "b": 3e-9}
    bounds = {
        RunKey("pd", name): {"theta": BoundedRecord(unit="rad", tolerance=size, basis="")}
        for name, size in sides.items()
    }
    about = Subject(ComparisonKey("deviation", "pd", "tip", *sides), "m", "largest")
    case = Case(arm, load_scenario("pd"), usual_switches(arm))
    cases = {RunKey("pd", name): case for name in sides}
    found, _ = _measurement_bound(make_measurement(about, measured=0.1), bounds, cases)
    assert found == pytest.approx(5e-9 * (first + 2 * second + 3 * third), rel=0.0101)


@pytest.mark.parametrize(
    ("value", "relative", "tolerance"),
    [
        (3.0, 0.5, 3e-6),  # a millionth of it
        (1e-6, 1e-6, 1e-10),  # a ten-thousandth of a millionth of the quantity, 1
        (2.0, None, 2e-6),
    ],
)
def test_what_has_no_measured_uncertainty_may_move_by_its_value_or_its_quantity(
    value, relative, tolerance
):
    about = Subject(ComparisonKey("energy", "pd", "drift", "a", "b"), "J", "largest")
    finding = make_measurement(about, measured=value, relative=relative)
    found, _ = _measurement_bound(finding, {}, {})
    assert found == pytest.approx(tolerance, rel=0.0101)


@pytest.mark.parametrize("value", [1.0, 1.234, 1.235, 9.996, 4.4441e-17, 8.0049e12])
def test_what_is_on_record_is_no_less_than_what_was_measured(value):
    """Three digits, upwards: by 1 % at most."""
    assert value <= _round_up(value) <= 1.0101 * value
