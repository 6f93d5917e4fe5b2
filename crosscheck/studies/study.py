"""Simulations of the paper's study: named, run in parallel, kept on disk by all their inputs."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from importlib import metadata
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import xarray as xr

from crosscheck.output import require_writable, write_text
from crosscheck.registry import build, model_class
from crosscheck.studies.sources import code_hash
from crosscheck.workers import perform_all
from models.errors import Diverged, InputError
from models.loading import Case, load_case
from models.trajectory import read_netcdf, write_netcdf

PACKAGES = ("numpy", "scipy", "numba", "pin", "exudyn", "xarray", "sympy")
PERTURBATION_M = 1e-12  # of every mesh displacement in a seeded start

Json = Any  # what json.dumps takes
Numbers = dict[str, float | None]
Measure = Callable[[xr.Dataset], Numbers]
Reduction = Callable[[xr.Dataset], xr.Dataset]


@dataclass(frozen=True)
class Variant:
    """One simulation: what differs from the built-in arm and scenario.

    zeta: damping ratio of all joints; ring_rate None follows the phase law; settings:
    ``path=value`` as on the command line; seed: perturb every mesh displacement of the start by up
    to 1e-12 m; step_s and record_every as in the scenario.
    """

    scenario: str = "pd"
    arm: str = "paper-labelled"
    phase: str = "angle"
    ring_rate: str | None = None
    zeta: float = 0.05
    model: str = "analytic:physical"
    duration_s: float | None = None
    settings: tuple[str, ...] = ()
    seed: int | None = None
    record_every: int = 2

    def case(self) -> Case:
        """Arm, scenario and switches. Raises InputError."""
        switches = {"phase": self.phase}
        if self.ring_rate is not None:
            switches["ring_rate"] = self.ring_rate
        settings = [f"arm.joints.*.damping_ratio={self.zeta!r}", *self.settings]
        settings.append(f"scenario.record_every={self.record_every}")
        if self.duration_s is not None:
            settings.append(f"scenario.duration_s={self.duration_s!r}")
        case = load_case(self.arm, self.scenario, switches, settings)
        return case if self.seed is None else _perturbed(case, self.seed)


def _perturbed(case: Case, seed: int) -> Case:
    generator = np.random.default_rng(seed)
    offsets = PERTURBATION_M * generator.uniform(-1, 1, (2, len(case.arm.joints)))
    update = {
        name: tuple(map(float, row))
        for name, row in zip(("sun_planet_offset_m", "planet_ring_offset_m"), offsets, strict=True)
    }
    start = case.scenario.start.model_copy(update=update)
    return case._replace(scenario=case.scenario.model_copy(update={"start": start}))


class Question(Protocol):
    """Work that is not one variant's run: a frozen dataclass of a module.

    inputs: all that its answer depends on besides code; cost: rough seconds.
    """

    @property
    def inputs(self) -> str: ...

    @property
    def cost(self) -> float: ...

    def answer(self) -> Json: ...


@dataclass
class Study:
    """Runs variants and remembers them in a folder; tells how far it is.

    told(what, done, total) is called before and after every simulation of a request.
    """

    folder: Path
    jobs: int = 1
    told: Callable[[str, int, int], None] = lambda what, done, total: None
    made: int = field(default=0, init=False)
    found: int = field(default=0, init=False)

    def runs(
        self, variants: Iterable[Variant], what: str = "runs", keep: Reduction | None = None
    ) -> dict[Variant, xr.Dataset]:
        """Trajectories, whole or what ``keep`` keeps of them. Raises Diverged if one diverges.

        ``keep``: a function of a module.
        """
        wanted = list(dict.fromkeys(variants))
        paths = {variant: self.folder / f"{_key(variant, keep)}.nc" for variant in wanted}
        tasks = [_Task(path, _cost(v), partial(_write_run, v, keep)) for v, path in paths.items()]
        self._perform(tasks, what)
        return {variant: read_netcdf(path) for variant, path in paths.items()}

    def measures(
        self, variants: Sequence[Variant], measure: Measure, what: str = "measures"
    ) -> list[Numbers]:
        """Numbers of each variant's trajectory, worked out where it ran; only they are kept.

        ``measure``: a function of a module. A run that diverges gives {"diverged_s": time}.
        """
        paths = [self.folder / f"{_key(variant, measure)}.json" for variant in variants]
        todo = dict(zip(paths, variants, strict=True))
        self._perform(
            [
                _Task(path, _cost(v), partial(_write_measure, v, measure))
                for path, v in todo.items()
            ],
            what,
        )
        return [_kept(path) for path in paths]

    def answers(self, questions: Sequence[Question], what: str) -> list[Json]:
        """Of each question, worked out once and kept."""
        paths = [self.folder / f"{_question_key(question)}.json" for question in questions]
        todo = dict(zip(paths, questions, strict=True))
        tasks = [_Task(path, q.cost, partial(_write_answer, q)) for path, q in todo.items()]
        self._perform(tasks, what)
        return [_kept(path) for path in paths]

    def _perform(self, tasks: Sequence[_Task], what: str) -> None:
        """Those whose results are not there yet."""
        require_writable(self.folder)
        missing = [task for task in tasks if not task.path.exists()]
        done = len(tasks) - len(missing)
        self.found += done
        self.told(what, done, len(tasks))

        def finished(_: str) -> None:
            nonlocal done
            done += 1
            self.made += 1
            self.told(what, done, len(tasks))

        for error in perform_all(missing, self.jobs, finished).values():
            if error is not None:
                raise error


@dataclass(frozen=True)
class _Task:
    """Work that leaves its result in a file, for another process."""

    path: Path
    cost: float
    make: Callable[[Path], None]

    @property
    def key(self) -> str:
        return str(self.path)

    def perform(self) -> Exception | None:
        try:
            self.make(self.path)
        except Exception as error:  # handed to the caller's process
            return error
        return None


def _write_run(variant: Variant, keep: Reduction | None, path: Path) -> None:
    run = simulate(variant)
    write_netcdf(run if keep is None else keep(run), path)


def _write_measure(variant: Variant, measure: Measure, path: Path) -> None:
    try:
        numbers = measure(simulate(variant))
    except Diverged as error:
        numbers = {"diverged_s": error.time_s}
    _write_json(numbers, path)


def _write_answer(question: Question, path: Path) -> None:
    _write_json(question.answer(), path)


def _write_json(value: Json, path: Path) -> None:
    write_text(path, json.dumps(value, allow_nan=False) + "\n")


def _kept(path: Path) -> Json:
    """What was written there. Raises InputError if the file has been damaged since."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        reason = f"is damaged ({error}); `crosscheck cache clear` removes it"
        raise InputError(str(path), "", None, reason) from None


def simulate(variant: Variant) -> xr.Dataset:
    """The variant's trajectory. Raises InputError and Diverged."""
    return build(variant.model, *variant.case()).simulate()


def _cost(variant: Variant) -> float:
    return (variant.duration_s or 3.0) * (12 if variant.model.startswith("exudyn") else 0.5)


def _key(variant: Variant, measure: Measure | Reduction | None = None) -> str:
    inputs = [variant.model, *(record.model_dump_json() for record in variant.case())]
    modules = [model_class(variant.model).__module__, __name__]
    if measure is not None:
        inputs.append(measure.__qualname__)
        modules.append(measure.__module__)
    return _hash(inputs, modules)


def _question_key(question: Question) -> str:
    kind = type(question)
    return _hash([kind.__qualname__, question.inputs], [kind.__module__, __name__])


def _hash(inputs: Sequence[str], modules: Sequence[str]) -> str:
    """Of everything that a result depends on: inputs, versions and the code that runs."""
    text = "\n".join([*inputs, code_hash(*modules), *_versions()])
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@lru_cache
def _versions() -> tuple[str, ...]:
    return tuple(f"{name} {metadata.version(name)}" for name in PACKAGES)


def cache_folder() -> Path:
    """Where simulations are kept between runs: the user's cache folder."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "geararm-crosscheck"


def clear_cache() -> int:
    """Remove all kept simulations; returns how many files there were."""
    folder = cache_folder()
    count = sum(1 for path in folder.glob("*") if path.is_file()) if folder.exists() else 0
    shutil.rmtree(folder, ignore_errors=True)
    return count
