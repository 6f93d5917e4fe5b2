"""The result of a cross-check: Findings, gathered in one Agreement of which all else is a view."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from crosscheck.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd

SCHEMA_VERSION = 2
FindingKind = Literal["check", "measurement"]
Verdict = Literal["agree", "differ", "unresolved", "unfinished", "failed", "measured"]
MOST_LISTED = 3  # lines that a result prints of what does not agree
UNFINISHED_CODE = 3  # exit code where nothing differs, and something was not judged


@dataclass(frozen=True)
class ComparisonKey:
    """The name of a comparison: what is compared, in which case, between which models.

    ``family``: the kind of comparison (states, same-step, ...); ``case``: the arm or experiment;
    ``left`` and ``right``: models, ``right`` empty where one model is compared with something else;
    ``joint``: its number, where one joint alone is looked at.
    """

    family: str
    case: str
    quantity: str
    left: str
    right: str = ""
    joint: int | None = None

    @property
    def id(self) -> str:
        """The key as one text, for people and files; nothing reads it back."""
        joint = "" if self.joint is None else f"joint{self.joint}"
        models = "~".join(filter(None, (self.left, self.right)))
        return "/".join(filter(None, (self.family, self.case, joint, self.quantity, models)))


@dataclass(frozen=True)
class Subject:
    """Subject of a comparison: key, unit, metric; ``against``: the other side."""

    key: ComparisonKey
    unit: str
    metric: str
    against: str = ""


@dataclass(frozen=True)
class Finding:
    """The result of one comparison.

    Args:
        about: What was compared, with its unit.
        kind: ``check``, which must agree, or ``measurement``, which quantifies a difference.
        verdict: ``agree``, ``differ``, ``unresolved``, ``unfinished`` or ``failed``; ``measured``
            of a measurement.
        measured: The difference, in the unit of ``about``; None where there is no answer.
        tolerance: The largest difference that agrees, in the same unit; None of a measurement.
        basis: Where the tolerance comes from.
        relative: The measured difference over the size of the quantity.
        note: What a reader should know.
    """

    about: Subject
    kind: FindingKind
    verdict: Verdict
    measured: float | None = None
    tolerance: float | None = None
    basis: str = ""
    relative: float | None = None
    note: str = ""

    @property
    def id(self) -> str:
        """The key of the comparison as one text, see ``ComparisonKey.id``."""
        return self.about.key.id

    @property
    def quantity(self) -> str:
        """Name of the quantity that was compared."""
        return self.about.key.quantity

    @property
    def unit(self) -> str:
        """Unit of ``measured`` and ``tolerance``."""
        return self.about.unit

    @property
    def left(self) -> str:
        """Name of the first model."""
        return self.about.key.left

    @property
    def right(self) -> str:
        """Name of the other model, or what the first is compared with in its place."""
        return self.about.key.right or self.about.against

    def to_dict(self) -> dict[str, Any]:
        """The finding as a dictionary, as in crosscheck/schema/agreement.schema.json."""
        key = self.about.key
        return {
            "id": key.id,
            "family": key.family,
            "case": key.case,
            "joint": key.joint,
            "kind": self.kind,
            "quantity": key.quantity,
            "unit": self.unit,
            "left": self.left,
            "right": self.right,
            "metric": self.about.metric,
            "measured": self.measured,
            "tolerance": self.tolerance,
            "basis": self.basis,
            "verdict": self.verdict,
            "relative": self.relative,
            "note": self.note,
        }


def make_check(
    about: Subject,
    *,
    measured: float,
    tolerance: float,
    basis: str,
    resolved: bool = True,
    relative: float | None = None,
    note: str = "",
) -> Finding:
    """The Finding of a check: `agree` within the tolerance, else `differ`.

    `unresolved` where the tolerance itself, being a numerical uncertainty, is too large to mean
    anything; `failed` where there is no number.
    """
    if not math.isfinite(measured):
        return make_failed_check(about, "the difference is not a number")
    if not math.isfinite(tolerance):
        return make_failed_check(about, f"no tolerance can be given: {basis}")
    verdict: Verdict = "agree" if measured <= tolerance else "differ"
    if verdict == "agree" and not resolved:
        verdict = "unresolved"
    relative = _replace_nonfinite(relative)
    return Finding(about, "check", verdict, measured, tolerance, basis, relative, note)


def make_share_check(
    about: Subject, measured: float, share: float, size: float, of: str, reason: str = ""
) -> Finding:
    """Make the Finding of a check whose tolerance is a share of a size in ``about``'s unit.

    of: the quantity whose size it is; reason: why the share is that large.
    """
    basis = f"{share:g} of {of}, {size:.3g} {about.unit}{reason}"
    tolerance, relative = share * size, measured / size if size else None
    return make_check(about, measured=measured, tolerance=tolerance, basis=basis, relative=relative)


def make_measurement(
    about: Subject,
    *,
    measured: float,
    basis: str = "",
    relative: float | None = None,
    note: str = "",
) -> Finding:
    """The Finding of a measurement: the size of a difference that nobody expects to vanish.

    A difference that is no number gives a failed check: a model somewhere gave none.
    """
    if not math.isfinite(measured):
        return make_failed_check(about, "the difference is not a number")
    relative = _replace_nonfinite(relative)
    return Finding(about, "measurement", "measured", measured, None, basis, relative, note)


def make_failed_check(about: Subject, note: str) -> Finding:
    """The Finding of a check that could not be made: a model missing, raising or diverged."""
    return Finding(about, "check", "failed", note=note)


def make_unfinished_check(about: Subject, note: str) -> Finding:
    """The Finding of a check not made: a model was stopped before it answered, right or wrong."""
    return Finding(about, "check", "unfinished", note=note)


def _replace_nonfinite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


SYMBOLS = {"mass_matrix": "M", "bias": "bias", "generalized_force": "force"}


@dataclass(frozen=True)
class WrongEntry:
    """An entry in which a model differs from the engines, by how much of the entry's size.

    places: row and column, counted from 0; one column of a vector; two places of a symmetric pair.
    """

    name: str
    places: tuple[tuple[int, int], ...]
    relative: float


@dataclass(frozen=True)
class EntryDifferences:
    """How far a model is from the engines, entry by entry.

    quantity: mass_matrix, bias or generalized_force; engines: the models it is compared with;
    coordinates: their names; relative: by row and column (of a vector one column), the largest
    difference over states and engines, over the entry's size; tolerance: what is allowed of it.
    """

    quantity: str
    model: str
    engines: tuple[str, ...]
    coordinates: tuple[str, ...]
    relative: tuple[tuple[float, ...], ...]
    tolerance: float

    def wrong_entries(self) -> list[WrongEntry]:
        """The entries beyond the tolerance, largest first; M_ij and M_ji are one."""
        values = ((i, j, x) for i, row in enumerate(self.relative) for j, x in enumerate(row))
        beyond = {(i, j): x for i, j, x in values if not x <= self.tolerance}
        entries = []
        for i, j in beyond:
            pair = ((i, j),) if i == j or (j, i) not in beyond else ((i, j), (j, i))
            if pair == tuple(sorted(pair)):
                largest = max(beyond[place] for place in pair)
                entries.append(WrongEntry(self._entry_name(i, j), pair, largest))
        return sorted(entries, key=lambda entry: -entry.relative)

    def _entry_name(self, row: int, column: int) -> str:
        names = [self.coordinates[row]]
        names += [self.coordinates[column]] if len(self.relative[row]) > 1 else []
        return f"{SYMBOLS[self.quantity]}[{', '.join(names)}]"


@dataclass(frozen=True)
class Agreement:
    """All Findings of a cross-check, with where they come from.

    Args:
        findings: The results of all comparisons, in the order of the plan.
        provenance: Versions, inputs and machine that they come from.
        record: Provenance of the recorded cross-check that this one is compared with, if one is.
        accepted_keys: Keys of the checks of which the record accepts a difference.
        entries: Models beside the engines entry by entry, as far as that was asked.
    """

    findings: Sequence[Finding]
    provenance: Provenance | None = None
    record: Provenance | None = None
    accepted_keys: Sequence[ComparisonKey] = ()
    entries: Sequence[EntryDifferences] = ()

    def __repr__(self) -> str:
        """How many checks agree, and the first that do not."""
        red, total = self.disagreeing, len(self.checks)
        lines = [f"Agreement: {total - len(red)} of {total} checks agree"]
        return "\n".join([*lines, *list_first([f"{each.verdict} {each.id}" for each in red])])

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each Finding, with the fields of ``Finding.to_dict``."""
        import pandas as pd

        return pd.DataFrame([finding.to_dict() for finding in self.findings])

    @property
    def disagreeing(self) -> list[Finding]:
        """The checks that differ, are unresolved, unfinished or failed."""
        return [f for f in self.findings if f.kind == "check" and f.verdict != "agree"]

    @property
    def checks(self) -> list[Finding]:
        """The Findings that must agree."""
        return [f for f in self.findings if f.kind == "check"]

    @property
    def exit_code(self) -> int:
        """Exit code: 0 if all checks agree, 3 if all others are unfinished; 1 also without any."""
        red = self.disagreeing
        if red and all(finding.verdict == "unfinished" for finding in red):
            return UNFINISHED_CODE
        return 0 if self.checks and not red else 1

    def to_dict(self) -> dict[str, Any]:
        """The agreement as a dictionary, as in crosscheck/schema/agreement.schema.json."""
        provenance = self.provenance
        return {
            "schema_version": SCHEMA_VERSION,
            "findings": [finding.to_dict() for finding in self.findings],
            "provenance": {} if provenance is None else provenance.model_dump(mode="json"),
        }

    def to_json(self) -> str:
        """Readable JSON of to_dict, ending in a newline."""
        return json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n"


def list_first(lines: Sequence[str]) -> list[str]:
    """The first of the lines, and how many more there are."""
    more = len(lines) - MOST_LISTED
    return [*lines[:MOST_LISTED], *([f"... and {more} more"] if more > 0 else [])]
