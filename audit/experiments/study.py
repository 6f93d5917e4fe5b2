"""Work of the paper's study: questions, answered in parallel, kept on disk by all their inputs."""

from __future__ import annotations

import hashlib
import json
import platform
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, Generic, TypeVar, get_type_hints

from pydantic import BaseModel, TypeAdapter

from crosscheck.models.errors import Diverged, InputError, Unfinished
from crosscheck.provenance import find_version
from crosscheck.registry import MODELS
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.progress_update import ProgressCallback, ignore_progress
from crosscheck.runner.sources import compute_code_hash
from crosscheck.runner.store import Store
from crosscheck.runner.workers import Workers

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
    def key(self) -> str:
        """The key of the answer."""
        return question_key(self)

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

    def perform(self) -> bytes | InputError | Diverged:
        """The answer's content, as of a task for another process, or the caller's own error."""
        try:
            return self.encode(self.answer())
        except (InputError, Diverged) as error:
            return error

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


Key = TypeVar("Key")
Value = TypeVar("Value")


@dataclass
class Study:
    """The answers to questions, kept in a folder; reports its progress.

    progress(what, done, total) counts results, before and after every task of a request. What
    cannot be kept, or does not fit any more, is made again.
    """

    folder: Path
    jobs: int = 1
    progress: ProgressCallback = ignore_progress
    computed_count: int = field(default=0, init=False)
    cached_count: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self.store = Store(self.folder)

    def answer_questions(self, questions: Sequence[Question[Value]], label: str) -> list[Value]:
        """The answer to each question, worked out once and kept.

        Raises what went wrong after all others are kept; a divergence last of all.
        """
        keys = [question.key for question in questions]
        question_by_key = dict(zip(keys, questions, strict=True))
        answers: dict[str, Value | Diverged] = {}
        for key, question in question_by_key.items():
            with suppress(KeyError):
                answers[key] = self.store.get(key, question.decode)
        self.cached_count += len(answers)
        done, total = len(answers), len(question_by_key)
        self.progress(label, done, total)
        tasks = [q for k, q in question_by_key.items() if k not in answers]
        errors = list[Exception]()
        with Workers(min(self.jobs, len(tasks))) as workers:
            for key, result in workers.stream_longest_first(tasks):
                question = question_by_key[key]
                if isinstance(result, Failure):
                    errors.append(Unfinished(f"{label}: {type(question).__name__}: {result}"))
                elif isinstance(result, InputError):
                    errors.append(result)
                elif isinstance(result, Diverged):
                    answers[key] = result
                else:
                    self._keep(key, result)
                    answers[key] = question.decode(result)
                done, self.computed_count = done + 1, self.computed_count + 1
                self.progress(label, done, total)
        if errors:
            raise errors[0]
        return [raise_if_diverged(answers[key]) for key in keys]

    def _keep(self, key: str, content: bytes) -> None:
        try:
            self.store.put(key, content)
        except OSError as error:
            self.store.give_up(error)

    def answer_by_key(
        self, questions: Mapping[Key, Question[Value]], label: str
    ) -> dict[Key, Value]:
        """The answer to each question, by the question's key in the mapping."""
        return dict(
            zip(questions, self.answer_questions(list(questions.values()), label), strict=True)
        )


def question_key(question: Question[object]) -> str:
    """The key of a question's answer."""
    kind = type(question)
    modules = [kind.__module__, *(MODELS[name].module for name in question.model_names)]
    computing = sorted({name for entry in MODELS.values() for name in entry.versioned_packages})
    inputs = kind.__qualname__, question.inputs
    text = "\n".join([*inputs, compute_code_hash(*modules), *_versions(*computing)])
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@lru_cache
def _versions(*packages: str) -> tuple[str, ...]:
    """Names and versions of Python and of the packages that compute; None for a missing engine."""
    python = f"python {platform.python_version()} {platform.machine()}"
    return (python, *(f"{name} {find_version(name)}" for name in packages))


def raise_if_diverged(result: Value | Diverged) -> Value:
    """The result itself. Raises it if it is Diverged."""
    if isinstance(result, Diverged):
        raise result
    return result
