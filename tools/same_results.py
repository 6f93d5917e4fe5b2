"""``python tools/same_results.py BEFORE AFTER``: do two JSON results hold the same numbers?

Of agreement.json, claims.json or a baseline, made before and after a change of the code. Prints
every path at which they differ, and leaves with exit code 1 if there is one. Provenance (date,
versions, revision) is left out, and so are the seconds that something took.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

LEFT_OUT = {"provenance", "seconds"}
NOTHING = object()


def find_differences(before: object, after: object, path: str = "") -> Iterator[str]:
    """Where two JSON values differ, each as a line; records of a list are matched by their id."""
    if isinstance(before, dict) and isinstance(after, dict):
        for name in [*before, *(name for name in after if name not in before)]:
            if name not in LEFT_OUT:
                before_value, after_value = before.get(name, NOTHING), after.get(name, NOTHING)
                yield from find_differences(before_value, after_value, f"{path}.{name}")
    elif isinstance(before, list) and isinstance(after, list):
        yield from find_differences(_index_by_id(before), _index_by_id(after), path)
    elif before is NOTHING:
        yield f"{path}: only after"
    elif after is NOTHING:
        yield f"{path}: only before"
    elif before != after:
        yield f"{path}: {before!r} before, {after!r} after"


def _index_by_id(values: list[object]) -> dict[str, object]:
    """By the records' ids where all have one of their own, else by place."""
    ids = [str(value["id"]) for value in values if isinstance(value, dict) and "id" in value]
    if len(set(ids)) == len(values):
        return dict(zip(ids, values, strict=True))
    return {str(place): value for place, value in enumerate(values)}


def main() -> None:
    """Compare the two files that are named."""
    before, after = (json.loads(Path(name).read_text(encoding="utf-8")) for name in sys.argv[1:3])
    lines = list(find_differences(before, after))
    print("\n".join(lines) if lines else "the same numbers")
    sys.exit(bool(lines))


if __name__ == "__main__":
    main()
