"""The Agreement as JUnit XML, which every build server shows."""

from __future__ import annotations

import re
from dataclasses import replace
from xml.etree import ElementTree

from crosscheck.findings import Agreement, Finding
from crosscheck.report.formatting import describe_outcome

# XML 1.0 has no way to write these; an exception's message may hold them.
_UNWRITABLE = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def format_junit(agreement: Agreement, suite: str = "crosscheck") -> str:
    """XML text with a test case per check, which has an ``error`` where it was not judged."""
    cases = [_case(finding) for finding in agreement.checks]
    counts = {
        "tests": str(len(cases)),
        "failures": str(sum(case.find("failure") is not None for case in cases)),
        "errors": str(sum(case.find("error") is not None for case in cases)),
        "skipped": "0",
        "time": "0",
    }
    root = ElementTree.Element("testsuites", counts)
    only = ElementTree.SubElement(root, "testsuite", {"name": suite, **counts})
    if agreement.provenance is not None:
        only.set("timestamp", agreement.provenance.created.partition("+")[0])
    only.append(_properties(agreement))
    only.extend(cases)
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _case(finding: Finding) -> ElementTree.Element:
    key = finding.about.key
    # Consumers take dots for packages.
    classname = ".".join(part.replace(".", "_") for part in (key.family, key.case) if part)
    name = replace(key, family="", case="").id
    named = {"classname": _clean(classname), "name": _clean(name), "time": "0"}
    case = ElementTree.Element("testcase", named)
    summary = f"{describe_outcome(finding)}{f' ({finding.basis})' if finding.basis else ''}"
    if finding.verdict != "agree":
        kind = "error" if finding.verdict in ("failed", "unfinished") else "failure"
        verdict = {"type": finding.verdict, "message": _clean(f"{finding.verdict}: {summary}")}
        details = "\n".join(f"{name}: {value}" for name, value in finding.to_dict().items())
        ElementTree.SubElement(case, kind, verdict).text = _clean(details)
    ElementTree.SubElement(case, "system-out").text = _clean(summary)
    return case


def _properties(agreement: Agreement) -> ElementTree.Element:
    """An XML element of the provenance, as far as it is text and numbers, and the measurements."""
    provenance, named = agreement.provenance, list[tuple[str, object]]()
    if provenance is not None:
        named += [field for field in provenance if isinstance(field[1], str | int | None)]
        named += [(f"version {name}", value) for name, value in provenance.versions.items()]
    if agreement.accepted_keys:
        named.append(("known", ", ".join(key.id for key in agreement.accepted_keys)))
    for finding in agreement.findings:
        if finding.kind == "measurement":
            named.append((finding.id, f"{finding.measured!r} {finding.unit}"))
    properties = ElementTree.Element("properties")
    for name, value in named:
        pair = {"name": _clean(name), "value": _clean(str(value))}
        ElementTree.SubElement(properties, "property", pair)
    return properties


def _clean(text: str) -> str:
    return _UNWRITABLE.sub("\N{REPLACEMENT CHARACTER}", text)
