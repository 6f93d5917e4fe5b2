"""Entry points of installed packages: their code is run when one is loaded."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from typing import Any

from crosscheck.models.errors import InputError
from crosscheck.runner.interruption import was_stopped
from crosscheck.runner.supervision import overseen


def loaded(offer: EntryPoint) -> Any:
    """The object that an entry point names. Raises InputError where it cannot be imported."""
    try:
        with overseen(f"package {_owner(offer)}: entry point {offer.name}"):
            return offer.load()
    except BaseException as error:
        if was_stopped():
            raise
        reason = " ".join(str(error).split())
        raise unusable(offer, f"cannot be imported: {type(error).__name__}: {reason}") from None


def unusable(offer: EntryPoint, why: str) -> InputError:
    """The error for an entry point that names nothing of use."""
    return InputError(f"package {_owner(offer)}", f"entry point {offer.name}", offer.value, why)


def _owner(offer: EntryPoint) -> str:
    return offer.dist.name if offer.dist else "an installed package"
