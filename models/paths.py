"""Dotted paths into the raw content of arms, scenarios and switches, as users write them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from copy import deepcopy
from fnmatch import fnmatchcase
from typing import Any

from crosscheck.models.errors import InputError

SECTIONS = ("arm", "scenario", "switches")
FieldPath = tuple[str | int, ...]  # path of one entry: keys of tables, indices in lists


def is_path(path: str, sections: Sequence[str] = SECTIONS) -> bool:
    """Whether a text is a path to something below one of the sections."""
    keys = path.strip().split(".")
    return len(keys) > 1 and keys[0] in sections and all(keys)


def find_paths(data: dict[str, Any], path: str, option: str) -> list[FieldPath]:
    """All entries that match a path, one or more.

    ``*`` stands for each of a list, and in a name for any text: ``*_mesh`` is both meshes of a
    joint, and none of a joint without gears. The last key need not be in its table yet. option:
    what to name in a message. Raises InputError.
    """
    keys = path.strip().split(".")
    matches: list[tuple[FieldPath, Any]] = [((), data)]
    for depth, key in enumerate(keys, start=1):
        so_far, is_last = ".".join(keys[:depth]), depth == len(keys)
        matches = [
            ((*place, step), None if is_last else target[step])
            for place, target in matches
            for step in _steps(target, key, so_far, option, must_exist=not is_last)
        ]
        if not matches:
            raise InputError(option, so_far, None, "no such entry")
    return [place for place, _ in matches]


def value_at(data: dict[str, Any], place: FieldPath) -> Any:
    """Value at a place of the raw content; None if there is none."""
    target: Any = data
    for step in place:
        if isinstance(target, dict) and step not in target:
            return None
        target = target[step]
    return target


def assign(data: dict[str, Any], place: FieldPath, value: Any) -> None:
    """Put a value at a place of the raw content, as a copy that no other place refers to."""
    target: Any = data
    for step in place[:-1]:
        target = target[step]
    target[place[-1]] = deepcopy(value)


def format_path(place: FieldPath) -> str:
    """A place as messages show it, such as ``arm.joints[0].sun_mesh.backlash_m``."""
    return "".join(f"[{s}]" if isinstance(s, int) else f".{s}" for s in place).removeprefix(".")


def _steps(target: Any, key: str, path: str, option: str, must_exist: bool) -> Iterable[str | int]:
    if isinstance(target, list):
        return _indices(target, key, path, option)
    if isinstance(target, dict) and "*" in key:
        return [name for name in target if fnmatchcase(name, key)]
    if not isinstance(target, dict) or (must_exist and key not in target):
        raise InputError(option, path, None, "no such entry")
    return [key]


def _indices(target: list[Any], key: str, path: str, option: str) -> Iterable[int]:
    if key == "*":
        return range(len(target))
    if not re.fullmatch("[0-9]{1,9}", key) or int(key) >= len(target):
        raise InputError(option, path, None, f"index must be * or 0 to {len(target) - 1}")
    return [int(key)]
