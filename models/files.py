"""The files of arms, robots and scenarios as they stand: TOML, read and not validated.

Light on purpose: a list of what there is waits for no schema.
"""

from __future__ import annotations

import copy
import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

from crosscheck.models.errors import InputError
from crosscheck.models.file_kind import XmlKind, describe_xml_kind
from crosscheck.models.inputs import convert_read_errors, read_content

HERE = Path(__file__).parent
BUILTIN_FOLDERS = ("arms", "robots", "scenarios")  # folders of what has built-in names
LARGEST_FILE = 4_000_000  # size of a file [bytes]; a table of 50,000 rows for seven joints has it
LONGEST_BITS = 1000  # bits of the longest whole number; Python shows none of 4300 digits
URDF = ".urdf"
TOO_LONG = "a number of too many digits"
EXPAND = "expand it first: xacro robot.urdf.xacro > robot.urdf"
# Fields that files of one kind alone have, and the kind, with what to do with such a file.
KINDS = {
    frozenset({"quantities"}): "a study; `crosscheck sweep` runs it",
    frozenset({"urdf"}): "a robot",
    frozenset({"links", "joints"}): "an arm",
    frozenset({"drive", "duration_s"}): "a scenario",
    frozenset({"recordings"}): "a description of recordings; `crosscheck compare` reads it",
}
READ_AS_URDF = (XmlKind.URDF, XmlKind.XACRO, XmlKind.MJCF)
DEEPEST_KEY = 50  # the parser takes a time with the square of a key's parts


def builtin_arms() -> tuple[str, ...]:
    """Names of the arms that come with the project."""
    return _stems("arms")


def builtin_scenarios() -> tuple[str, ...]:
    """Names of the scenarios that come with the project."""
    return _stems("scenarios")


def builtin_robots() -> tuple[str, ...]:
    """Names of the robots that come with the project."""
    return _stems("robots")


def builtin_title(folder: Literal["arms", "robots", "scenarios"], name: str) -> str:
    """Title of an arm, robot or scenario that comes with the project, read without validation."""
    return str(_read(name, folder).get("title", ""))


def read_raw_arm(name: str) -> dict[str, Any]:
    """The content of an arm's file, not validated. Raises InputError."""
    return _require_kind(_read(name, "arms"), name, "an arm")


def read_raw_scenario(name: str) -> dict[str, Any]:
    """The content of a scenario's file, not validated. Raises InputError."""
    return _require_kind(_read(name, "scenarios"), name, "a scenario")


def _require_kind(content: dict[str, Any], name: str, kind: str) -> dict[str, Any]:
    """The content of a file. Raises InputError for a study, and for fields of other kinds alone."""
    kinds = [words for keys, words in KINDS.items() if not keys.isdisjoint(content)]
    if kinds and (kind not in kinds or "quantities" in content):
        what, mark, remedy = kinds[0].partition(";")
        raise InputError(name, "", None, f"is {what}, not {kind}{mark}{remedy}")
    return content


def read_raw_robot(name: str) -> dict[str, Any]:
    """The content of a robot's file, not validated. Raises InputError."""
    return _read(name, "robots")


def is_robot(name: str) -> bool:
    """Whether a name is a robot's, where an arm's may stand: built-in, XML or a file of one.

    An arm on a free base is one too. Raises InputError.
    """
    if name in (*builtin_arms(), *builtin_robots()):
        return name in builtin_robots()
    if Path(name).suffix == URDF:
        return True
    text = _text(name, "arms", "robots")
    return describe_xml_kind(text) is not None or not {"urdf", "base"}.isdisjoint(
        _parse(text, name, "arms")
    )


def is_urdf(name: str) -> bool:
    """Whether a robot's name is that of a URDF, or of MJCF, which is read as one.

    Whatever the file is called. Raises InputError.
    """
    if name in builtin_robots() or Path(name).suffix == URDF:
        return name not in builtin_robots()
    return describe_xml_kind(_text(name, "robots")) in READ_AS_URDF


def read_toml(path: Path) -> dict[str, Any]:
    """The content of a TOML file that has no built-in name. Raises InputError."""
    return _read(str(path), "")


def _stems(folder: str) -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in (HERE / folder).glob("*.toml")))


def _read(name: str, folder: str) -> dict[str, Any]:
    """The raw TOML of a built-in name, else of a file."""
    return _parse(_text(name, *filter(None, [folder])), name, folder)


def _text(name: str, *folders: str) -> str:
    """The text of a built-in name in these folders, else of a file. Raises InputError."""
    for folder in folders:
        if name in _stems(folder):
            return (HERE / folder / f"{name}.toml").read_text("utf-8")
    with convert_read_errors(name), suppress(FileNotFoundError, NotADirectoryError):
        return read_content(Path(name), LARGEST_FILE).decode("utf-8-sig")
    names = [stem for folder in folders for stem in _stems(folder)]
    nor = f", nor built-in name ({', '.join(names)})" if folders else ""
    other = [kind for kind in BUILTIN_FOLDERS if folders and name in _stems(kind)]
    nor += f"; it is one of {other[0]}" if other else ""
    raise InputError(name, "", None, f"no such file{nor}")


def _parse(text: str, where: str, folder: str) -> dict[str, Any]:
    """The TOML of a text. Raises InputError, which names the kind of an XML text."""
    if not text.strip():
        raise InputError(where, "", None, "is empty; a TOML file is expected")
    if kind := describe_xml_kind(text):
        raise InputError(where, "", None, f"is {kind}; {_remedy(kind, folder)}")
    try:
        return parse_toml(text)
    except ValueError as error:
        raise InputError(where, "", None, f"is not TOML: {error}") from None


def _remedy(kind: XmlKind, folder: str) -> str:
    """The file to give in place of an XML file, and the commands that take it."""
    expand = f"; {EXPAND}" if kind is XmlKind.XACRO else ""
    if folder == "robots":
        return f"must be a URDF, or a robot's TOML file{expand}"
    if folder == "arms":
        its = "it" if kind in (XmlKind.URDF, XmlKind.MJCF) else "a URDF"
        return f"an arm's TOML file is expected; other commands take {its}{expand}"
    return "a TOML file is expected"


def parse_toml(text: str) -> dict[str, Any]:
    """Parsed TOML. Raises ValueError, also for what would take too long or go too deep."""
    return copy.deepcopy(_parse_toml(text))  # which takes a tenth of the time


@lru_cache(maxsize=64)
def _parse_toml(text: str) -> dict[str, Any]:
    words = re.split(r"[\n,={}\[\]]", text.replace(" ", "").replace("\t", ""))
    if any(word.count(".") > DEEPEST_KEY and ".." not in word for word in words):
        raise ValueError(f"a key of more than {DEEPEST_KEY} parts")
    try:
        content = tomllib.loads(text)
    except RecursionError:
        raise ValueError("nested too deeply") from None
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:
        raise ValueError(TOO_LONG) from None
    if any(
        isinstance(value, int) and value.bit_length() > LONGEST_BITS
        for value in list_leaf_values(content)
    ):
        raise ValueError(TOO_LONG)
    return content


def format_toml_fields(record: Mapping[str, object]) -> Iterator[str]:
    """The fields of a record of JSON's values as lines of TOML, those that are None left out."""
    for name, value in record.items():
        if value is not None:
            key = name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name)
            yield f"{key} = {_format_toml(value)}"


def _format_toml(value: object) -> str:
    """A value as TOML in one line, every digit of a number."""
    if isinstance(value, dict):
        return f"{{ {', '.join(format_toml_fields(value))} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(_format_toml, value))}]"
    return json.dumps(value, ensure_ascii=False)


def list_leaf_values(content: object) -> Iterator[object]:
    """Every value that is no table or list, however deep."""
    left = [content]
    while left:
        value = left.pop()
        if isinstance(value, dict | list):
            left += value.values() if isinstance(value, dict) else value
        else:
            yield value
