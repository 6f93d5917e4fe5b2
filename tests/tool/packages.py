"""A distribution, as an installer leaves it, that offers a command or a model."""

from pathlib import Path

ENTRY = """
from crosscheck.registry import STATES, Entry

it = Entry("guest", "C", "geared", STATES{})
"""


def offer(folder: Path, text: str, group: str = "commands", name: str = "guest") -> str:
    """Put one into a folder, with ``it`` of a module of this text; returns the folder."""
    (folder / "guest.py").write_text(f"import os, sys\n{text}\n", encoding="utf-8")
    about = folder / "guest_engine-1.5.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: guest-engine\nVersion: 1.5\n")
    (about / "entry_points.txt").write_text(f"[geararm_crosscheck.{group}]\n{name} = guest:it\n")
    return str(folder)
