"""What can go wrong through no fault of the program: one clear line each."""

from __future__ import annotations


class InputError(ValueError):
    """Something the user gave cannot be used.

    ``str(error)`` is one line naming where (file or option), the field, the value and what is
    allowed.
    """

    def __init__(self, where: str, field: str, value: object, allowed: str) -> None:
        self.where, self.field, self.value, self.allowed = where, field, value, allowed
        named = f"{where}: {field}" if field else where
        shown = "" if value is None else f" = {_short(value)}"
        super().__init__(f"{named}{shown}: {allowed}")

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, object, str]]:
        """So that it can be sent from one process to another."""
        return InputError, (self.where, self.field, self.value, self.allowed)


class Diverged(ArithmeticError):
    """A simulation left the range in which its numbers mean anything."""

    def __init__(self, model: str, time_s: float) -> None:
        self.model, self.time_s = model, time_s
        super().__init__(f"{model}: diverged at t = {time_s:.6g} s")

    def __reduce__(self) -> tuple[type[Diverged], tuple[str, float]]:
        """So that it can be sent from one process to another."""
        return Diverged, (self.model, self.time_s)


class Unfinished(RuntimeError):
    """A simulation came to no end: its process died or hung, or it raised."""


class CannotDo(NotImplementedError):
    """A model was asked for something outside its abilities."""


def _short(value: object, limit: int = 200) -> str:
    text = repr(value).replace("\n", " ")
    return text if len(text) <= limit else text[: limit - 3] + "..."
