"""The work of a study: tasks for other processes, each of which makes and keeps results."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import zip_longest
from typing import NamedTuple, Protocol, TypeVar, get_type_hints

import xarray as xr
from pydantic import TypeAdapter

from crosscheck.audit.experiments.packed import packed
from crosscheck.audit.experiments.variant import (
    Company,
    Measure,
    Variant,
    VariantComparison,
    company,
    integration,
    simulate_all,
)
from crosscheck.models.errors import Diverged, InputError
from crosscheck.registry import entry_of
from crosscheck.runner.outcomes import Failure, failure
from crosscheck.runner.store import Store

Value = TypeVar("Value")
Answer = TypeVar("Answer", covariant=True)
Reduction = Callable[[xr.Dataset], xr.Dataset]
Run = xr.Dataset | Diverged
MOST_AT_ONCE = 300_000  # records of runs in one task: about 200 MB


class Question(Protocol[Answer]):
    """Work that is not one variant's run: a frozen dataclass of a module.

    inputs: all that its answer depends on besides code; cost: rough seconds; it may have run_by:
    names of models that it runs and its module does not import. The answer, of the type that
    ``answer`` is annotated with (records, numbers, lists of them), is kept as JSON.
    """

    @property
    def inputs(self) -> str: ...

    @property
    def cost(self) -> float: ...

    def answer(self) -> Answer: ...


def whole(result: Value | Diverged) -> Value:
    """The result. Raises Diverged."""
    if isinstance(result, Diverged):
        raise result
    return result


Content = bytes | Failure | InputError | Diverged


class Made(NamedTuple):
    """Of a result's key and its task's name: its content, or why there is none or it is not kept.

    Errors that are the caller's come from another process as they are.
    """

    key: str
    name: str
    content: Content
    not_kept: OSError | None = None


class Piece(NamedTuple):
    """A result, and how it is made of the variant's run."""

    key: str
    variant: Variant
    make: Callable[[Run], bytes]


@dataclass(frozen=True)
class AuditTask:
    """Work for another process, which keeps all its results by their keys.

    runs: how many integrations it makes; of a Question one.
    """

    key: str
    name: str
    cost: float
    keys: tuple[str, ...]
    make: Callable[[], list[Callable[[], bytes]]]
    store: Store
    runs: int = 1

    def perform(self) -> list[Made]:
        try:
            results = self.make()
        except Exception as error:
            return [Made(key, self.name, _reason(error)) for key in self.keys]
        return [self._made(key, make) for key, make in zip(self.keys, results, strict=True)]

    def _made(self, key: str, make: Callable[[], bytes]) -> Made:
        try:
            content = make()
        except Exception as error:
            return Made(key, self.name, _reason(error))
        try:
            self.store.put(key, content)
        except OSError as error:
            return Made(key, self.name, content, error)
        return Made(key, self.name, content)


def _reason(error: Exception) -> Failure | InputError | Diverged:
    return error if isinstance(error, InputError | Diverged) else failure(error)


def made_by(task: AuditTask, outcome: list[Made] | Failure) -> list[Made]:
    """What a task made; its failure for every result if its process died."""
    if isinstance(outcome, Failure):
        return [Made(key, task.name, outcome) for key in task.keys]
    return outcome


def integrations(pieces: Iterable[Piece], store: Store, jobs: int = 1) -> list[AuditTask]:
    """Tasks for all pieces: those of one integration in one, with as many beside it as fit.

    jobs: processes that share the work.
    """
    together: dict[str, list[Piece]] = {}
    for piece in pieces:
        together.setdefault(integration(piece.variant), []).append(piece)
    alike: dict[Company, list[list[Piece]]] = {}
    for made_at_once in together.values():
        alike.setdefault(company(made_at_once[0].variant), []).append(made_at_once)
    batches = [[_batch(g, store) for g in _shared_out(groups, jobs)] for groups in alike.values()]
    # In turns, so that processes begin with unlike kernels and none compiles what another does.
    return [task for turn in zip_longest(*batches) for task in turn if task is not None]


def _shared_out(groups: Sequence[list[Piece]], jobs: int) -> Iterator[Sequence[list[Piece]]]:
    """Integrations that could all run side by side, in as many tasks as memory and jobs ask for."""
    first = groups[0][0].variant
    scenario = first.case().scenario
    fit = max(1, MOST_AT_ONCE * scenario.stride // scenario.steps)
    size = min(entry_of(first.model).abreast, fit, -(-len(groups) // jobs))
    for begin in range(0, len(groups), size):
        yield groups[begin : begin + size]


def _batch(groups: Sequence[list[Piece]], store: Store) -> AuditTask:
    """One task for integrations that run side by side."""
    pieces = [piece for group in groups for piece in group]
    return AuditTask(
        pieces[0].key,
        pieces[0].variant.model,
        sum(_cost(group[0].variant) for group in groups),
        tuple(piece.key for piece in pieces),
        partial(_integrated, groups),
        store,
        len(groups),
    )


def _integrated(groups: Sequence[Sequence[Piece]]) -> list[Callable[[], bytes]]:
    runs = simulate_all([[piece.variant for piece in group] for group in groups])
    return [
        partial(piece.make, run)
        for group, found in zip(groups, runs, strict=True)
        for piece, run in zip(group, found, strict=True)
    ]


def inquiry(key: str, question: Question[object], store: Store) -> AuditTask:
    name = type(question).__name__
    return AuditTask(key, name, question.cost, (key,), partial(_asked, question), store)


def _asked(question: Question[object]) -> list[Callable[[], bytes]]:
    return [partial(_encoded, question)]


def kept(keep: Reduction | None, run: Run) -> bytes:
    """A run as it is kept. Raises Diverged."""
    this = whole(run)
    return packed(this if keep is None else keep(this))


def measured(measure: Measure | VariantComparison, others: Sequence[Run], run: Run) -> bytes:
    """Numbers of a run; when it, or one that it is compared with, diverged."""
    try:
        this, beside = whole(run), tuple(map(whole, others))
        if isinstance(measure, VariantComparison):
            return _json(measure.numbers(this, beside))
        return _json(measure(this))
    except Diverged as error:
        return _json({"diverged_s": error.time_s})


def _json(value: object) -> bytes:
    return json.dumps(value, allow_nan=False).encode()


def _encoded(question: Question[object]) -> bytes:
    return _json(_adapter(question).dump_python(question.answer()))


def decoded(question: Question[Value], content: bytes) -> Value:
    return _adapter(question).validate_python(json.loads(content))


def _adapter(question: Question[Value]) -> TypeAdapter[Value]:
    """How the answers to a question are written and read."""
    return TypeAdapter(get_type_hints(type(question).answer)["return"])


def _cost(variant: Variant) -> float:
    """Rough seconds of an integration, from what the registry says of a step."""
    return variant.case().scenario.steps * entry_of(variant.model).call_s
