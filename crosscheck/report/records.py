"""Records as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from pydantic_core import to_json


def to_json_value(value: Any, **named: str) -> Any:
    """The form of a value that JSON takes: records as their fields, arrays as lists.

    named: other names for fields of records, wherever these stand. What is not finite is None.
    """

    def rename(record: dict[str, Any]) -> dict[str, Any]:
        return {named.get(name, name): each for name, each in record.items()}

    text = to_json(value, inf_nan_mode="null", fallback=lambda array: array.tolist())
    return json.loads(text, object_hook=rename)


def format_json(content: Mapping[str, Any]) -> str:
    """The content as readable JSON text, ending in a newline."""
    return json.dumps(to_json_value(content), indent=1, allow_nan=False) + "\n"
