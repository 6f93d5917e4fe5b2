"""Work of the paper's study that is not one variant's run."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Generic, TypeVar

from pydantic import BaseModel

Answer = TypeVar("Answer", covariant=True)
Records = Iterable[BaseModel]


class Question(ABC, Generic[Answer]):
    """A question, answered once and kept; a subclass is a frozen dataclass of a module.

    The answer, of the type that ``answer`` is annotated with (records, numbers, lists of them), is
    kept as JSON. Besides code it depends on the fields and on ``records``. cost: estimated [s].
    """

    @property
    @abstractmethod
    def cost(self) -> float: ...

    @property
    def model_names(self) -> tuple[str, ...]:
        """Names of the models that the question runs and its module does not import."""
        return ()

    @property
    def inputs(self) -> str:
        """All that the answer depends on besides code, as text."""
        return describe_inputs(self.records(), repr(self))

    @abstractmethod
    def records(self) -> Records:
        """The arms, scenarios and switches that the answer depends on."""

    @abstractmethod
    def answer(self) -> Answer: ...


def describe_inputs(records: Records, *more: str) -> str:
    """What a result depends on as text, a line each: records with all their fields, and more."""
    return "\n".join([*more, *(record.model_dump_json() for record in records)])
