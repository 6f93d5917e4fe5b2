"""Work of the paper's study that is not one variant's run."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Any, Generic, TypeVar, get_type_hints

from pydantic import BaseModel, TypeAdapter

Answer = TypeVar("Answer", covariant=True)
Records = Iterable[BaseModel]


class Question(ABC, Generic[Answer]):
    """A question, answered once and kept; a subclass is a frozen dataclass of a module.

    The answer, of the type that ``answer`` is annotated with (records, numbers, lists of them), is
    kept as JSON unless ``encode`` says otherwise. Besides code it depends on the fields and on
    ``records``. cost: estimated [s].
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
        return "\n".join([repr(self), *(record.model_dump_json() for record in self.records())])

    @abstractmethod
    def records(self) -> Records:
        """The arms, scenarios and switches that the answer depends on."""

    @abstractmethod
    def answer(self) -> Answer: ...

    def encode(self, answer: Any) -> bytes:
        """The answer as it is kept."""
        return json.dumps(self._adapter.dump_python(answer), allow_nan=False).encode()

    def decode(self, content: bytes) -> Answer:
        """The answer from what was kept. Raises ValueError or KeyError if that is none."""
        answer: Answer = self._adapter.validate_python(json.loads(content))
        return answer

    @property
    def _adapter(self) -> TypeAdapter[Any]:
        return TypeAdapter(get_type_hints(type(self).answer)["return"])
