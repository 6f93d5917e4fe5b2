"""What the numbers of a batch depend on besides the study: packages and the project's own code."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable
from functools import cache
from typing import Any

from crosscheck import __version__
from crosscheck.models.errors import InputError
from crosscheck.provenance import version
from crosscheck.registry import MODELS, lead, second
from crosscheck.runner.sources import code_hash

BATCH = "crosscheck.studies.batches.batch"


@cache
def fingerprint() -> str:
    """Of this process: equal where the same study gives the same numbers."""
    run_by = [MODELS[name] for name in (lead(), second())]
    packages = sorted({name for entry in run_by for name in entry.versioned})
    models = [entry.module for entry in run_by]
    parts = [
        f"python {platform.python_version()} {platform.machine()}",
        *(f"{name} {version(name) or 'missing'}" for name in packages),
        f"crosscheck {__version__} {code_hash(BATCH, *models)[:16]}",
    ]
    return ", ".join(parts)


def digest_of(*parts: object) -> str:
    """A name for what depends on all of these."""
    return hashlib.sha256("\n".join(map(str, parts)).encode()).hexdigest()[:32]


def differs(ours: str, theirs: str) -> str:
    """Of two fingerprints what is unlike, in words."""
    pairs = zip(ours.split(", "), theirs.split(", "), strict=False)
    return "; ".join(f"{a} here, {b} there" for a, b in pairs if a != b) or "another one"


def require_same(ours: str, theirs: str, worker: str) -> None:
    """Raise InputError unless a worker's fingerprint is the one that is expected."""
    if ours != theirs:
        allowed = f"runs another version: {differs(ours, theirs)}"
        raise InputError("--scheduler", "", worker, allowed)


def performed_as(expected: str, function: Callable[..., Any], *arguments: Any) -> Any:
    """What a function gives, where the versions are those that are expected. Raises InputError."""
    require_same(expected, fingerprint(), f"a worker on {platform.node()}")
    return function(*arguments)
