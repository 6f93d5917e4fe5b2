"""Code of installed packages: whatever it does is one line that names the package."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from importlib.metadata import EntryPoint
from typing import Any

from crosscheck.models.errors import InputError, describe_error, describe_type
from crosscheck.runner.interruption import was_stopped
from crosscheck.runner.supervision import track_foreign_code

PROGRAM = "geararm-crosscheck"  # distribution whose own entry points are not foreign code
COMMAND_S = 3600.0  # rough cost [s] of a package's command, see CpuTimeLimit


@contextmanager
def foreign_code(whose: str, cost: float = 5.0) -> Iterator[None]:
    """Run a package's code in this context. Raises InputError for whatever it raises.

    whose: how the error line begins; cost: estimated [s], see CpuTimeLimit.
    """
    try:
        with track_foreign_code(whose, cost):
            yield
    except BaseException as error:
        if was_stopped() or isinstance(error, InputError):
            raise
        raise InputError(whose, "", None, f"raised {describe_error(error)}") from None


def load_entry(offer: EntryPoint) -> Any:
    """The object that an entry point names. Raises InputError where it cannot be imported."""
    try:
        with track_foreign_code(f"package {_owner(offer)}: entry point {offer.name}"):
            return offer.load()
    except BaseException as error:
        if was_stopped():
            raise
        raise entry_point_error(offer, f"cannot be imported: {describe_error(error)}") from None


def load_record(
    offer: EntryPoint, kind: type, fields: Mapping[str, type | tuple[type, ...]]
) -> Any:
    """The record of a kind that an entry point names. Raises InputError for anything else.

    fields: the types of those fields that are read before anything else is asked.
    """
    record = load_entry(offer)
    if not isinstance(record, kind):
        expected = f"{kind.__module__}.{kind.__qualname__}"
        raise entry_point_error(offer, f"must be a {expected}, is {type(record).__name__}")
    for name, types in fields.items():
        if not isinstance(getattr(record, name), types):
            raise entry_point_error(offer, f"{name} is {describe_type(getattr(record, name))}")
    return record


def load_command(offer: EntryPoint, usage_errors: tuple[type[BaseException], ...]) -> Callable:
    """The function of a command that an entry point names, guarded where it is a package's.

    usage_errors: what a command may raise to end, or to say that it was called wrongly. Raises
    InputError where there is no such function.
    """
    command = load_entry(offer)
    if not callable(command) or isinstance(command, type):
        raise entry_point_error(offer, f"must be a function, is {type(command).__name__}")
    if _owner(offer) == PROGRAM:
        return command
    whose = f"package {_owner(offer)}: command {offer.name}"

    @wraps(command)
    def run(*arguments: Any, **options: Any) -> Any:
        ended: BaseException
        with foreign_code(whose, COMMAND_S):
            try:
                return command(*arguments, **options)
            except usage_errors as error:
                ended = error
        raise ended

    return run


def entry_point_error(offer: EntryPoint, why: str) -> InputError:
    """The error for an entry point that names nothing of use."""
    return InputError(f"package {_owner(offer)}", f"entry point {offer.name}", offer.value, why)


def _owner(offer: EntryPoint) -> str:
    return offer.dist.name if offer.dist else "an installed package"
