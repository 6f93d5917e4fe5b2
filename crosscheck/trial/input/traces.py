"""Tracebacks of a user's code, from its own first line on."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from traceback import StackSummary, TracebackException

import numpy as np

import crosscheck
from crosscheck.models.errors import one_line
from crosscheck.runner.outcomes import Failure, failure

# Numpy's frames count where we call it; a user's own frame comes before those of a user's call.
OURS = tuple(Path(str(own.__file__)).parent for own in (crosscheck, np))


def told_failure(error: BaseException) -> Failure:
    """An exception with the state at which it was raised and, if it is the user's, its traceback.

    The message is one line of at most 400 characters.
    """
    known, notes = failure(error), "; ".join(getattr(error, "__notes__", ()))
    message = one_line(f"{known.message} ({notes})" if notes else known.message)
    return Failure(known.kind, message, own_trace(error))


def own_trace(error: BaseException) -> str:
    """The traceback without the frames by which the user's code was reached; '' if there is none.

    Of exceptions that led to each other all are told, without notes.
    """
    told = TracebackException.from_exception(error, compact=True)
    chain = list(_chained(told))
    for each in chain:
        each.stack = StackSummary.from_list(_from_users(each.stack))
        each.__notes__ = []
    return "".join(told.format()) if any(each.stack for each in chain) else ""


def _chained(told: TracebackException | None) -> Iterator[TracebackException]:
    while told is not None:
        yield told
        told = told.__cause__ or told.__context__


def _from_users(stack: StackSummary) -> list:
    """The frames from the first on that is none of ours."""
    frames = list(stack)
    while frames and any(own in Path(frames[0].filename).parents for own in OURS):
        frames.pop(0)
    return frames
