"""The JUnit view of an Agreement, read back as a build server reads it."""

from xml.etree import ElementTree

from crosscheck.findings import (
    Agreement,
    ComparisonKey,
    Finding,
    Subject,
    make_check,
    make_failed_check,
    make_measurement,
    make_unfinished_check,
)
from crosscheck.models.loading import load_arm
from crosscheck.provenance import record_provenance
from crosscheck.report.junit import format_junit


def _about(family: str, quantity: str = "theta") -> Subject:
    return Subject(ComparisonKey(family, "pd", quantity, "a", "b"), "rad", "largest")


def _agreement() -> Agreement:
    findings: list[Finding] = [
        make_check(_about("same-step"), measured=1e-12, tolerance=1e-10, basis="x"),
        make_check(_about("same-step", "x.y"), measured=1e-8, tolerance=1e-10, basis="<&>"),
        make_check(_about("r"), measured=0.0, tolerance=1.0, resolved=False, basis="u"),
        make_failed_check(_about("run"), "RuntimeError: \x1b[31mno\x00 engine\ufffe"),
        make_measurement(_about("deviation"), measured=0.1),
    ]
    made = {"created": "2024-01-02T03:04:05+00:00", "versions": {"pin": "4"}}
    here = record_provenance(load_arm("probe"), 0, True)
    return Agreement(findings, here.model_copy(update=made))


def test_what_was_not_judged_is_an_error_and_no_failure():
    found = Agreement([make_unfinished_check(_about("run"), "stopped"), *_agreement().findings])
    root = ElementTree.fromstring(format_junit(found))
    assert (root.get("failures"), root.get("errors")) == ("2", "2")
    assert [case.get("type") for case in root.iter("error")] == ["unfinished", "failed"]


def test_measurements_and_versions_are_properties():
    agreement = _agreement()
    root = ElementTree.fromstring(format_junit(agreement))
    found = {item.get("name"): item.get("value") for item in root.iter("property")}
    assert agreement.provenance is not None
    written = agreement.provenance.model_dump(mode="json")
    simple = {name: each for name, each in written.items() if not isinstance(each, list | dict)}
    assert {type(each) for each in simple.values()} >= {int, str, bool}
    assert {name: str(each) for name, each in simple.items()}.items() <= found.items()
    assert found["deviation/pd/theta/a~b"] == "0.1 rad"
    assert found["version pin"] == "4"
    assert not {"arm", "versions"} & set(found)  # no text or number


def test_an_agreement_without_findings_is_a_suite_without_tests():
    assert ElementTree.fromstring(format_junit(Agreement([]))).get("tests") == "0"
