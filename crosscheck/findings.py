"""The result of a cross-check: Findings, gathered in one Agreement of which all else is a view."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

SCHEMA_VERSION = 1
Kind = Literal["check", "measurement"]
Verdict = Literal["agree", "differ", "unresolved", "failed", "measured"]


@dataclass(frozen=True)
class Finding:
    """One comparison of two models.

    ``kind``: a ``check`` must agree, a ``measurement`` quantifies a difference. ``measured`` and
    ``tolerance`` are in ``unit``; ``relative`` is the measured difference over the size of the
    quantity. ``basis`` says where the tolerance comes from, ``note`` what a reader should know.
    """

    id: str
    kind: Kind
    quantity: str
    unit: str
    left: str
    right: str
    metric: str
    measured: float | None
    tolerance: float | None
    basis: str
    verdict: Verdict
    relative: float | None = None
    note: str = ""


def checked(*, measured: float, tolerance: float, resolved: bool = True, **fields: Any) -> Finding:
    """A check: `agree` within the tolerance, else `differ`.

    `unresolved` where the tolerance itself, being a numerical uncertainty, is too large to mean
    anything; `failed` where there is no number.
    """
    if not math.isfinite(measured):
        return failed(**{**fields, "note": "the difference is not a number"})
    verdict: Verdict = "agree" if measured <= tolerance else "differ"
    if verdict == "agree" and not resolved:
        verdict = "unresolved"
    return Finding(kind="check", measured=measured, tolerance=tolerance, verdict=verdict, **fields)


def measured_only(*, measured: float, **fields: Any) -> Finding:
    """A measurement: the size of a difference that nobody expects to vanish."""
    return Finding(
        kind="measurement", measured=measured, tolerance=None, verdict="measured", **fields
    )


def failed(*, note: str, **fields: Any) -> Finding:
    """A check that could not be made: a model missing, raising or diverged."""
    fields = {"basis": "", **fields, "note": note}
    return Finding(kind="check", measured=None, tolerance=None, verdict="failed", **fields)


@dataclass(frozen=True)
class Agreement:
    """All Findings of a run, with where they come from."""

    findings: Sequence[Finding]
    provenance: Mapping[str, Any] = field(default_factory=dict)

    @property
    def red(self) -> list[Finding]:
        """The checks that differ, are unresolved or failed."""
        return [f for f in self.findings if f.kind == "check" and f.verdict != "agree"]

    @property
    def checks(self) -> list[Finding]:
        """The Findings that must agree."""
        return [f for f in self.findings if f.kind == "check"]

    @property
    def exit_code(self) -> int:
        """0 if every check agrees and there is at least one, else 1."""
        return 0 if self.checks and not self.red else 1

    def to_dict(self) -> dict[str, Any]:
        """As in crosscheck/schema/agreement.schema.json."""
        return {
            "schema_version": SCHEMA_VERSION,
            "findings": [asdict(finding) for finding in self.findings],
            "provenance": dict(self.provenance),
        }

    def to_json(self) -> str:
        """Readable JSON of to_dict, ending in a newline."""
        return json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n"
