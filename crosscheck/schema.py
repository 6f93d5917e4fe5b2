"""Fields of an arm or an experiment, read from the schema, for docs and templates."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from textwrap import dedent
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

from pydantic.fields import FieldInfo

from crosscheck.models.arm.quantities import Data, Limit, NumberRange, SharedValue


@dataclass(frozen=True)
class FieldDescription:
    """A field: its meaning, the unit of its numbers, and what it may be.

    default: None also where another field may stand instead. lists: how many tables it is a list
    of, in words, if it is one. records: the tables that it may be, or hold. applies_to: what one
    value stands for all of, in words, if a list may stand in its place.
    """

    name: str
    meaning: str
    unit: str
    required: bool
    default: object
    allowed: str
    lists: str
    records: tuple[type[Data], ...]
    applies_to: str = ""


@cache
def describe_fields(record: type[Data]) -> tuple[FieldDescription, ...]:
    """The fields of a record, in their order."""
    hints = get_type_hints(record, include_extras=True)
    holders = [base for base in reversed(record.__mro__) if issubclass(base, Data)]
    meanings = {name: text for base in holders for name, text in _read_meanings(base).items()}
    fields = record.model_fields.items()
    return tuple(_describe_field(n, info, hints[n], meanings.get(n, "")) for n, info in fields)


@cache
def _read_meanings(record: type[Data]) -> dict[str, str]:
    """The text below each field of a record in its source, by the field's name."""
    (definition,) = ast.parse(dedent(inspect.getsource(record))).body
    assert isinstance(definition, ast.ClassDef)
    return {
        ast.unparse(field.target): inspect.cleandoc(str(text.value.value))
        for field, text in pairwise(definition.body)
        if isinstance(field, ast.AnnAssign)
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
    }


def _describe_field(name: str, info: FieldInfo, hint: Any, meaning: str) -> FieldDescription:
    units = [limit.unit for limit in _parts(hint) if isinstance(limit, NumberRange)]
    types = [part for part in _parts(hint) if isinstance(part, type)]
    records = [part for part in dict.fromkeys(types) if issubclass(part, Data)]
    applies_to = next((str(part) for part in _parts(hint) if isinstance(part, SharedValue)), "")
    listed = any(get_origin(part) is tuple for part in _parts(hint))
    infos = [part for part in _parts(hint) if isinstance(part, FieldInfo)]
    limited = [i for i in infos if any(hasattr(e, "max_length") for e in i.metadata)]
    return FieldDescription(
        name=name,
        meaning=meaning,
        unit=next(iter(units), ""),
        required=info.is_required(),
        default=None if info.is_required() else info.get_default(call_default_factory=True),
        allowed="" if records else _describe_allowed(hint) + applies_to,
        lists=_describe_count(limited[0]) if records and listed and not applies_to else "",
        records=tuple(records),
        applies_to=applies_to,
    )


def _parts(hint: Any) -> Iterator[Any]:
    """The hint of a type, and all types and metadata inside it."""
    yield hint
    if get_origin(hint) is not Literal:
        for part in get_args(hint):
            yield from _parts(part)


def _describe_allowed(hint: Any) -> str:
    """Values that a type allows, in words, without its unit."""
    origin, inner = get_origin(hint), get_args(hint)
    if hint is bool:
        return "true or false"
    if origin is Literal:
        return " or ".join(", ".join(f'"{choice}"' for choice in inner).rsplit(", ", 1))
    if origin is Annotated:
        base, *metadata = inner
        for entry in metadata:
            if isinstance(entry, NumberRange):
                return f"{replace(entry, unit='')}{', whole' * (base is int)}"
            if isinstance(entry, Limit):
                return str(entry)
            if isinstance(entry, FieldInfo) and get_args(base)[-1:] == (...,):
                element = _describe_allowed(get_args(base)[0])
                return f"a list of {_describe_count(entry)}, each {element}"
        return _describe_allowed(base)
    if origin is tuple:
        return f"a list of {len(inner)}, each {_describe_allowed(inner[0])}"
    some = [part for part in inner if part is not NoneType]
    single = [part for part in some if not _is_list(part)]
    return ", or ".join(map(_describe_allowed, single or some))


def _is_list(hint: Any) -> bool:
    return get_origin(get_args(hint)[0] if get_origin(hint) is Annotated else hint) is tuple


def _describe_count(info: FieldInfo) -> str:
    """How many entries a list may have, in words: ``least to most``."""
    least = next((e.min_length for e in info.metadata if hasattr(e, "min_length")), 0)
    most = next(e.max_length for e in info.metadata if hasattr(e, "max_length"))
    return f"{least} to {most}"
