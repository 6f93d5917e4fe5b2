"""Records as files that git can show the changes of: where they lie, writing, reading."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from crosscheck import __version__
from crosscheck.baseline.record import SCHEMA_VERSION, Baseline, Provenance, find_differences
from crosscheck.models.errors import InputError, rephrase
from crosscheck.models.inputs import read_content
from crosscheck.output import write_text
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.provenance import is_versioned, list_changed_files, mechanism_digest
from crosscheck.report.formatting import format_count

WIDTH = 100
# A number of more digits than this comes out of a computation and is written with all 17.
SHORT = 10
# Ten times the record of a full cross-check of seven joints.
LARGEST_BYTES = 20_000_000


def baseline_path(folder: Path, request: CrossCheckRequest) -> Path:
    """Path of an arm's baseline, such as paper-labelled-quick.json.

    Scenarios of the user's own are named behind a ``+`` each, supplied equations behind an ``@``.
    """
    names = (request.name, *(scenario.name for scenario in request.scenarios))
    tried = f"@{_encode_name(request.model)}" if request.model else ""
    kind = "quick" if request.quick else "full"
    return folder / f"{'+'.join(map(_encode_name, names))}{tried}-{kind}.json"


def _encode_name(name: str) -> str:
    """A name as part of a file's name.

    A name that is not plain lower case gets a digest behind a ``~``, which plain names have not:
    two names never share a file, nor do Arm and arm where the file system takes them for one.
    """
    if re.fullmatch(r"[a-z0-9._-]+", name):
        return name
    digest = hashlib.sha256(name.encode()).hexdigest()[:16]
    return f"{re.sub(r'[^A-Za-z0-9._-]+', '-', name)}~{digest}"


def write_baseline(path: Path, baseline: Baseline) -> None:
    """Write the file; it appears whole or not at all. Raises InputError."""
    write_text(path, "\n".join(_lines(baseline.model_dump(mode="json"))) + "\n")


def read_baseline(path: Path, request: CrossCheckRequest, renew: str) -> Baseline:
    """The baseline in a file, if it can be compared with what is wanted, by this version.

    renew: the command that makes it anew, for the message. Raises InputError.
    """
    try:
        content = _read_bytes(path)
    except FileNotFoundError:
        raise InputError(str(path), "", None, f"no such file; make it: {renew}") from None
    try:
        data = _parse_json(content)
        _require_version(data)
        baseline = _validate(data)
        _require_same_plan(baseline.provenance, request)
    except InputError as error:
        allowed = f"{error.allowed}; renew it: {renew}"
        raise InputError(str(path), error.field, error.value, allowed) from None
    return baseline


def require_replaceable(path: Path, request_name: str) -> None:
    """Raise InputError if something lies there that is no record of an arm or robot of this name.

    A damaged record that names none may be replaced: that is how it is renewed.
    """
    try:
        content = _read_bytes(path, remembered=False)
    except FileNotFoundError:
        return
    try:
        name: Any = _parse_json(content).get("provenance")
    except InputError:
        return
    if isinstance(name, dict):
        name = name.get("arm") or name.get("robot")
    name = name.get("name") if isinstance(name, dict) else None
    if isinstance(name, str) and name != request_name:
        allowed = f"another arm than {request_name!r} is on record here; move that file away first"
        raise InputError(str(path), "provenance.arm.name", name, allowed)


def require_committed(path: Path) -> None:
    """Raise InputError if a record would lie in this checkout and name a revision that is not run.

    A record elsewhere, or one that git ignores, is nobody's reference: its revision is marked.
    """
    if is_versioned(path) and (changed := list_changed_files()):
        more = f" and {format_count(len(changed) - 1, 'other file')}" if changed[1:] else ""
        allowed = f"{changed[0]}{more} in this checkout: no revision names what would be recorded"
        advice = "commit or stash first, or record elsewhere with --dir"
        raise InputError(str(path), "", None, f"uncommitted changes of {allowed}; {advice}")


def _read_bytes(path: Path, remembered: bool = True) -> bytes:
    """Content of a file. Raises FileNotFoundError, or InputError where it can be no record."""
    try:
        return read_content(path, LARGEST_BYTES, remembered)
    except FileNotFoundError:
        raise
    except ValueError as error:
        raise InputError(str(path), "", None, f"is not a record: {error}") from None
    except OSError as error:
        raise InputError(str(path), "", None, f"cannot be read: {error.strerror}") from None


def _parse_json(content: bytes) -> dict[str, Any]:
    """The JSON object that a record's content is. Raises InputError without the file."""
    try:
        data = json.loads(content.decode("utf-8"), object_pairs_hook=_reject_duplicates)
    except InputError:
        raise
    except (ValueError, RecursionError) as error:  # not UTF-8, truncated, garbled, bottomless
        raise InputError("", "", None, f"is not JSON: {error}") from None
    if not isinstance(data, dict):
        raise InputError("", "", data, "must be a JSON object")
    return data


def _reject_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    data: dict[str, Any] = {}
    for key, value in pairs:
        if key in data:
            raise InputError("", key, value, "is given twice")
        data[key] = value
    return data


def _require_version(data: dict[str, Any]) -> None:
    schema, version = data.get("schema_version"), data.get("project_version")
    if type(schema) is not int or schema != SCHEMA_VERSION:
        older = ", this is an older one" if type(schema) is int and schema < SCHEMA_VERSION else ""
        allowed = f"only format {SCHEMA_VERSION} is read{older}"
        raise InputError("", "schema_version", schema, allowed)
    major = __version__.split(".", 1)[0]
    if not isinstance(version, str) or version.split(".", 1)[0] != major:
        raise InputError("", "project_version", version, f"major version {major} is allowed")


def _validate(data: dict[str, Any]) -> Baseline:
    try:
        return Baseline.model_validate(data)
    except ValidationError as error:
        details = error.errors()[0]
    location = [str(part) for part in details["loc"]]
    if details["type"] == "value_error":  # of what belongs together: field|allowed
        field, _, allowed = str(details["ctx"]["error"]).rpartition("|")
        raise InputError("", ".".join([*location, field]), None, allowed)
    if details["type"] == "missing":
        raise InputError("", ".".join(location), None, "is missing; a value is required")
    raise InputError("", ".".join(location), details["input"], rephrase(details["msg"]))


def _require_same_plan(provenance: Provenance, request: CrossCheckRequest) -> None:
    mechanism = request.mechanism
    if provenance.quick != request.quick:
        needed = f"{'a --quick' if request.quick else 'a full'} record is needed here"
        raise InputError("", "provenance.quick", provenance.quick, needed)
    if provenance.model != request.model:
        needed = f"a record of {request.model or 'all models'} is needed here"
        raise InputError("", "provenance.model", provenance.model or None, needed)
    requested = {"scenarios": request.scenarios, "switches": request.chosen}
    for field, value in requested.items():
        if value != getattr(provenance, field):
            raise InputError("", f"provenance.{field}", None, f"made with other {field} than these")
    then, now, digest = provenance.content, mechanism.content, mechanism_digest(mechanism)
    if then == now and provenance.arm_sha256 == digest:
        return
    was, is_now = ({} if e is None else e.model_dump(mode="json") for e in (then, now))
    moved = next(find_differences(was, is_now), None)
    what = f": {moved[0]} was {moved[1]!r}, is {moved[2]!r}" if moved else ""
    allowed = f"another {mechanism.section} than {now.name}, which has {digest[:12]}{what}"
    raise InputError("", "provenance.arm_sha256", provenance.arm_sha256[:12], allowed)


def _lines(value: Any, indent: int = 0, head: str = "", tail: str = "") -> Iterator[str]:
    """Lines of JSON, keys sorted; whatever holds only scalars takes one line, if it fits."""
    pad = " " * indent
    named: list[tuple[str | None, Any]] = []
    if isinstance(value, dict):
        named = sorted(value.items())
    elif isinstance(value, list):
        named = [(None, item) for item in value]
    if not any(isinstance(item, dict | list) for _, item in named):
        inline = f"{pad}{head}{_inline(value)}{tail}"
        if len(inline) <= WIDTH or not isinstance(value, dict):
            yield inline
            return
    opening, closing = "{}" if isinstance(value, dict) else "[]"
    yield f"{pad}{head}{opening}"
    for number, (key, item) in enumerate(named, start=1):
        label = "" if key is None else f"{json.dumps(key)}: "
        yield from _lines(item, indent + 1, label, "," if number < len(named) else "")
    yield f"{pad}{closing}{tail}"


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        pairs = (f"{json.dumps(key)}: {_inline(item)}" for key, item in sorted(value.items()))
        return "{" + ", ".join(pairs) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_inline, value)) + "]"
    if isinstance(value, float):
        short = repr(value)
        return short if len(short) <= SHORT else f"{value:.16e}"
    return json.dumps(value)
