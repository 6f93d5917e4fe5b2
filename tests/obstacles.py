"""What may lie in the place of a file and is none."""

import os
from collections.abc import Callable
from pathlib import Path

OBSTACLES: dict[str, Callable[[Path], object]] = {
    "folder": Path.mkdir,
    "pipe": os.mkfifo,
    "loop": lambda path: path.symlink_to(path.name),
    "dangling": lambda path: path.symlink_to("nowhere"),
    "device": lambda path: path.symlink_to("/dev/zero"),
}


def obstruct(obstacle: str) -> Callable[[Path], object]:
    """What puts an obstacle in the place of a file."""
    return lambda path: (path.unlink(), OBSTACLES[obstacle](path))
