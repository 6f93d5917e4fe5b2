"""Public names of a package, imported when they are first used."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import Any


def make_lazy_names(
    package: str, modules: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Build the ``__getattr__`` and ``__dir__`` of a package whose names live in other modules.

    So the command line and a test module start without numpy, xarray or an engine.

    Args:
        package: Name of the package, for the message about an unknown name.
        modules: The module in which each public name is defined.
    """

    def get_attribute(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(importlib.import_module(modules[name]), name)

    def list_names() -> list[str]:
        special = [name for name in vars(importlib.import_module(package)) if name[:2] == "__"]
        return sorted({*modules, *special})

    return get_attribute, list_names
