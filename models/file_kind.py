"""Recognises XML files by their text, where another kind of file may be expected."""

from __future__ import annotations

import re
from enum import StrEnum

_COMMENT = re.compile(r"<!--.*?(?:-->|\Z)", re.DOTALL)
_PROLOGUE = re.compile(r"(?:\s|<\?.*?(?:\?>|\Z)|<![^>]*(?:>|\Z))*", re.DOTALL)
_OUTERMOST = re.compile(r"<([\w:.-]+)")
# Elements and expressions that xacro replaces; its namespace may stay in a URDF that it writes.
_UNEXPANDED = re.compile(r"<xacro:|[\"'][^\"'<>]*\$[{(]")


class XmlKind(StrEnum):
    """The content of an XML file, in the words of a message."""

    URDF = "a URDF"
    XACRO = "xacro"
    MJCF = "MJCF"
    SDF = "SDF"
    OTHER = "XML"


def describe_xml_kind(text: str) -> XmlKind | None:
    """The content of a text that begins with ``<``; None for any other text.

    The text need not be well-formed: its outermost element decides, and for ``robot`` whether
    something of xacro is left in it.
    """
    if not text.lstrip().startswith("<"):
        return None
    content = _COMMENT.sub("", text)
    prologue = _PROLOGUE.match(content)
    element = _OUTERMOST.match(content, prologue.end() if prologue else 0)
    name = element.group(1) if element else ""
    if name == "robot":
        return XmlKind.XACRO if _UNEXPANDED.search(content) else XmlKind.URDF
    return {"mujoco": XmlKind.MJCF, "sdf": XmlKind.SDF}.get(name, XmlKind.OTHER)
