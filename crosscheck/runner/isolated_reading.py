"""Files from outside, read in a process of their own, which a damaged one may bring down."""

from __future__ import annotations

import io
import signal
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.runner.outcomes import DIED, Failure, FunctionTask
from crosscheck.runner.workers import perform_all

SIGNATURE, USER_BLOCK = b"\x89HDF\r\n\x1a\n", 512  # of HDF5, at the beginning or behind this
# Largest count of numbers in a compressed file, which may be small itself.
MOST_NUMBERS = 100_000_000


def read_in_subprocess(
    where: str,
    read: Callable[..., Any],
    *arguments: Any,
    within_s: float = 0.0,
    fails: str = "cannot be read",
    dies: str = "",
) -> Any:
    """The value that read(*arguments) returns, in another process.

    within_s [s]: limit of its work; 0 sets none. Raises the InputError that it raises, and one of
    ``where`` that begins with ``fails`` for whatever else ends it; dies: what to say of a process
    that a file has ended, in place of how.
    """
    task = FunctionTask(_read_within, (within_s, partial(read, *arguments)))
    (result,) = perform_all([task], 1).values()
    if isinstance(result, Failure):
        reason = dies if dies and result.kind == DIED else result
        raise InputError(where, "", None, f"{fails}: {reason}")
    if isinstance(result, InputError):
        raise result
    return result


def _read_within(within_s: float, read: Callable[[], Any]) -> Any:
    """What a function reads in so many seconds [s] of work, 0 for any, or its InputError."""
    signal.setitimer(signal.ITIMER_PROF, within_s)  # which ends the process
    try:
        return read()
    except InputError as error:
        return error


class TooManyNumbers(ValueError):
    """An error for a file that holds more than MOST_NUMBERS."""


def read_arrays(
    content: bytes,
    select_names: Callable[[Iterable[str]], Iterable[str]],
    *,
    as_matlab: bool = False,
) -> dict[str, np.ndarray]:
    """The variables of a MAT, HDF5 or NetCDF file by name, those that are wanted of its names.

    as_matlab: whether an HDF5 file holds arrays column by column though it does not say so. Raises
    TooManyNumbers before it reads any, and whatever scipy and h5py raise.
    """
    if SIGNATURE not in (content[:8], content[USER_BLOCK : USER_BLOCK + 8]):
        import scipy.io  # a fifth of a second, for MAT files alone

        shapes = {name: shape for name, shape, _ in scipy.io.whosmat(io.BytesIO(content))}
        names = _require_affordable(select_names(shapes), shapes)
        variables = scipy.io.loadmat(io.BytesIO(content), variable_names=names)
        return {name: variables[name] for name in names}
    import h5py  # for recordings alone

    with h5py.File(io.BytesIO(content), "r") as file:
        # No link is followed, for it may lead out of the file.
        hard_links = [n for n in file if isinstance(file.get(n, getlink=True), h5py.HardLink)]
        members = {n: file[n] for n in hard_links if isinstance(file[n], h5py.Dataset)}
        sets = {n: each for n, each in members.items() if not (each.external or each.is_virtual)}
        shapes = {name: data.shape for name, data in sets.items()}
        names = _require_affordable(select_names(sets), shapes)
        turned = as_matlab or content[:6] == b"MATLAB"
        return {n: np.asarray(sets[n]).T if turned else np.asarray(sets[n]) for n in names}


def _require_affordable(names: Iterable[str], shapes: Mapping[str, tuple[int, ...]]) -> list[str]:
    """The names as a list. Raises TooManyNumbers where their arrays hold too many."""
    chosen = list(names)
    count = sum(float(np.prod(shapes[name], dtype=float)) for name in chosen)
    if count > MOST_NUMBERS:
        raise TooManyNumbers(f"holds {count:,.0f} numbers, at most {MOST_NUMBERS:,} are allowed")
    return chosen
