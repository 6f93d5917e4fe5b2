"""Records as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


def to_json_value(value: Any, **named: str) -> Any:
    """The form of a value that JSON takes: records as their fields, arrays as lists.

    named: other names for fields of records, wherever these stand. What is not finite is None.
    """
    if is_dataclass(value):
        return {
            named.get(field.name, field.name): to_json_value(getattr(value, field.name), **named)
            for field in fields(value)
        }
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {key: to_json_value(each, **named) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [to_json_value(each, **named) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def format_json(content: Mapping[str, Any]) -> str:
    """The content as readable JSON text, ending in a newline."""
    return json.dumps(to_json_value(content), indent=1, allow_nan=False) + "\n"
