"""Recorded results of a cross-check, as a file that git can show the changes of."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, ValidationError, model_validator

from crosscheck import __version__
from crosscheck.findings import Verdict
from crosscheck.output import write_text
from models.arm import Arm
from models.errors import InputError
from models.quantities import Data, Finite, NotNegative

SCHEMA_VERSION = 1
WIDTH = 100
# A number of more digits than this comes out of a computation and is written with all 17.
SHORT = 10
Row = Annotated[tuple[Finite, ...], Field(min_length=2, strict=False)]
Rows = Annotated[tuple[Row, ...], Field(min_length=1, strict=False)]


class Bounded(Data):
    """What a repetition may differ by, in ``unit``, and why; None: it is not compared.

    ``uncertainty``: numerical uncertainty by step refinement, None where it was not measured.
    """

    unit: str
    tolerance: NotNegative | None
    basis: str
    uncertainty: NotNegative | None = None


class Measurement(Bounded):
    """The number of a Finding of kind ``measurement``."""

    measured: Finite


class Sampled(Bounded):
    """A quantity at some times; rows of time [s] and a value per joint (planet 1)."""

    samples: Rows

    @model_validator(mode="after")
    def _is_a_table(self) -> Self:
        if len({len(row) for row in self.samples}) > 1:
            raise ValueError("samples|every row needs a time and as many joints as the others")
        return self


class Extremes(Bounded):
    """Extreme values over a run (planet 1); rows of joint, minimum, its time, maximum, its time.

    The times [s] are for the reader: of two peaks of one height, rounding picks the higher.
    """

    extremes: Rows

    @model_validator(mode="after")
    def _has_five_columns(self) -> Self:
        if any(len(row) != 5 for row in self.extremes):
            raise ValueError("extremes|a row is joint, minimum, its time, maximum, its time")
        return self


class Run(Data):
    """One simulation, reduced: the experiment as its Dataset states it, and numbers."""

    scenario: dict[str, Any]
    switches: dict[str, str]
    sampled: dict[str, Sampled]
    extremes: dict[str, Extremes]


class Provenance(Data):
    """Where the record comes from, as crosscheck.provenance has it."""

    model_config = ConfigDict(frozen=True, extra="allow", strict=True)

    arm: dict[str, Any]
    arm_sha256: str
    versions: dict[str, str | None]
    python: str
    machine: str
    revision: str | None
    lock_sha256: str | None


class Baseline(Data):
    """A cross-check of an arm on record; checks and measurements by id, runs by key."""

    schema_version: Literal[1] = 1
    project_version: str
    quick: bool
    seed: Annotated[int, Field(ge=0)]
    checks: dict[str, Verdict]
    measurements: dict[str, Measurement]
    runs: dict[str, Run]
    provenance: Provenance


def baseline_path(folder: Path, arm: Arm, quick: bool) -> Path:
    """Where the baseline of an arm lies, such as paper-labelled-quick.json."""
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", arm.name)
    return folder / f"{name}-{'quick' if quick else 'full'}.json"


def write_baseline(path: Path, baseline: Baseline) -> None:
    """Write the file; it appears whole or not at all. Raises InputError."""
    write_text(path, "\n".join(_lines(baseline.model_dump(mode="json"))) + "\n")


def read_baseline(path: Path, arm: Arm, renew: str) -> Baseline:
    """The baseline in a file, if it can be held against this arm and this version.

    renew: the command that makes it anew, for the message. Raises InputError.
    """
    data = _parsed(path, renew)
    _require(path, "schema_version", data.get("schema_version"), SCHEMA_VERSION, renew)
    version = data.get("project_version")
    if not isinstance(version, str) or _major(version) != _major(__version__):
        allowed = f"major version {_major(__version__)} is allowed; renew it: {renew}"
        raise InputError(str(path), "project_version", version, allowed)
    try:
        baseline = Baseline.model_validate(data)
    except ValidationError as error:
        raise _invalid(path, error, renew) from None
    _require_same_arm(path, baseline.provenance, arm, renew)
    return baseline


def arm_digest(arm: Arm) -> str:
    """SHA-256 of all of an arm's values, as provenance records it."""
    return hashlib.sha256(arm.model_dump_json().encode()).hexdigest()


def differences(one: Any, other: Any, path: str = "") -> Iterator[tuple[str, Any, Any]]:
    """(dotted path, left, right) wherever two trees of JSON values differ; None where missing."""
    if isinstance(one, dict) and isinstance(other, dict):
        for key in sorted({*one, *other}):
            yield from differences(one.get(key), other.get(key), f"{path}.{key}" if path else key)
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for index, (left, right) in enumerate(zip(one, other, strict=True)):
            yield from differences(left, right, f"{path}[{index}]")
    elif one != other:
        yield path, one, other


def _parsed(path: Path, renew: str) -> dict[str, Any]:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(str(path), "", None, f"no such file; make it: {renew}") from None
    except OSError as error:
        raise InputError(str(path), "", None, f"cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:  # not UTF-8, truncated, garbled, bottomless
        reason = " ".join(str(error).split())
        raise InputError(str(path), "", None, f"is not JSON: {reason}; renew it: {renew}") from None
    if not isinstance(data, dict):
        raise InputError(str(path), "", data, f"must be a JSON object; renew it: {renew}")
    return data


def _require(path: Path, field: str, value: Any, allowed: int, renew: str) -> None:
    if value != allowed or isinstance(value, bool):
        raise InputError(str(path), field, value, f"only {allowed!r} is allowed; renew it: {renew}")


def _major(version: str) -> str:
    return version.split(".", 1)[0]


def _invalid(path: Path, error: ValidationError, renew: str) -> InputError:
    details = error.errors()[0]
    field = ".".join(str(part) for part in details["loc"])
    allowed = details["msg"]
    value = None if details["type"] in ("missing", "value_error") else details["input"]
    if details["type"] == "value_error":
        last, _, allowed = str(details["ctx"]["error"]).partition("|")
        field = f"{field}.{last}"
    return InputError(str(path), field, value, f"{allowed}; renew it: {renew}")


def _require_same_arm(path: Path, provenance: Provenance, arm: Arm, renew: str) -> None:
    if provenance.arm_sha256 == arm_digest(arm):
        return
    moved = next(differences(provenance.arm, arm.model_dump(mode="json")), None)
    what = f": {moved[0]} was {moved[1]!r}, is {moved[2]!r}" if moved else ""
    raise InputError(
        str(path),
        "provenance.arm_sha256",
        provenance.arm_sha256[:12],
        f"another arm than {arm.name}, which has {arm_digest(arm)[:12]}{what}; renew it: {renew}",
    )


def _lines(value: Any, indent: int = 0, head: str = "", tail: str = "") -> Iterator[str]:
    """JSON with sorted keys in which whatever holds only scalars takes one line, if it fits."""
    pad = " " * indent
    inline = f"{pad}{head}{_inline(value)}{tail}" if _is_flat(value) else None
    if inline is not None and (len(inline) <= WIDTH or not isinstance(value, dict)):
        yield inline
        return
    opening, closing = "{}" if isinstance(value, dict) else "[]"
    yield f"{pad}{head}{opening}"
    named = sorted(value.items()) if isinstance(value, dict) else [(None, item) for item in value]
    for number, (key, item) in enumerate(named, start=1):
        label = "" if key is None else f"{json.dumps(key)}: "
        yield from _lines(item, indent + 1, label, "," if number < len(named) else "")
    yield f"{pad}{closing}{tail}"


def _is_flat(value: Any) -> bool:
    """Whether a value is a scalar or holds nothing but scalars."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return not any(isinstance(item, dict | list) for item in inner)


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        pairs = (f"{json.dumps(key)}: {_inline(item)}" for key, item in sorted(value.items()))
        return "{" + ", ".join(pairs) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_inline, value)) + "]"
    if isinstance(value, float):
        short = repr(value)
        return short if len(short) <= SHORT else f"{value:.16e}"
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
