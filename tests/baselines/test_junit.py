"""The JUnit view of an Agreement, read back as a build server reads it."""

from xml.etree import ElementTree

from crosscheck.findings import Agreement
from crosscheck.models.loading import load_arm
from crosscheck.provenance import record_provenance
from crosscheck.report.junit import format_junit
from tests.baselines.short import green, measurement


def test_measurements_and_versions_are_properties():
    made = {"created": "2024-01-02T03:04:05+00:00", "versions": {"pin": "4"}}
    provenance = record_provenance(load_arm("probe"), 0, True).model_copy(update=made)
    root = ElementTree.fromstring(
        format_junit(Agreement([green(), measurement("pd", 0.1)], provenance))
    )
    found = {item.get("name"): item.get("value") for item in root.iter("property")}
    written = provenance.model_dump(mode="json")
    simple = {name: each for name, each in written.items() if not isinstance(each, list | dict)}
    assert {type(each) for each in simple.values()} >= {int, str, bool}
    assert {name: str(each) for name, each in simple.items()}.items() <= found.items()
    assert found["deviation/pd/theta/a~b"] == "0.1 rad"
    assert found["version pin"] == "4"
    assert not {"arm", "versions"} & set(found)  # no text or number


def test_an_agreement_without_findings_is_a_suite_without_tests():
    assert ElementTree.fromstring(format_junit(Agreement([]))).get("tests") == "0"
