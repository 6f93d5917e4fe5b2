"""Run in a copy of the project: which keys change when every view and every text is edited.

``python edited_views.py NAMES``, a JSON file of [module, name] pairs; prints those whose code is
another one afterwards, as JSON.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from crosscheck.runner import sources
from tests.audit.views import is_view


def codes(names: list[tuple[str, str]]) -> dict[tuple[str, str], str]:
    for remembered in (sources.code_hash, sources.source_of, sources.uses):
        remembered.cache_clear()
    return {name: sources.code_hash(name) for name in names}


def edit(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    path.write_text(f"{text}\n# edited\n", encoding="utf-8")


if __name__ == "__main__":
    names = [(module, name) for module, name in json.loads(Path(sys.argv[1]).read_text("utf-8"))]
    before = codes(names)
    tool = sources.ROOT / sources.OWN
    for folder in (tool, tool / "audit"):
        for path in sorted(folder.rglob("*.*")):
            if is_view(path.relative_to(folder.parent)):
                edit(path)
    after = codes(names)
    json.dump([name for name in names if before[name] != after[name]], sys.stdout)
