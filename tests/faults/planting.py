"""Planted faults: a text of a model's own code that is changed, and the check that sees it.

The TOML files beside this one hold them, in groups that one check sees in one experiment, each a
row of what is wrong, where, the text there and what it becomes. Compiled and remembered functions
of the harmed model are replaced by their Python originals, so that a change reaches everything that
uses it; the control run without a fault is made in the same way.
"""

import __future__

import inspect
import sys
import textwrap
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from jinja2 import ChoiceLoader, DictLoader

from crosscheck.registry import load_model_class
from tests.faults import kernels
from tests.faults.kernels import Kernel

HERE = Path(__file__).parent
TREE, BODIES = "crosscheck.models.exudyn.tree", "crosscheck.models.exudyn.bodies"
INTERPRETED = {
    "analytic": ("crosscheck.analytic",),
    "exudyn:tree": (
        *(f"{TREE}.{name}" for name in ("mesh", "tree", "laws", "loads", "stiffness")),
        "crosscheck.models.robot.planar",
    ),
    "pinocchio": ("crosscheck.models.robot.planar",),
    "exudyn:bodies": (f"{BODIES}.stiffness", f"{BODIES}.contact"),
}
Laws = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Seen:
    """By what and where a fault is seen.

    model: which has the fault, if one has. check: one of ``checks.CHECKS``, of a quantity where it
    has several. against: the model that is compared with. arm: a built-in one, or one that the
    check has. drive: one of ``checks.DRIVES``. kernel: of analytic:physical's runs. laws: switches
    by name.
    """

    model: str
    check: str
    quantity: str = ""
    against: str = ""
    arm: str = "probe"
    drive: str = "pd"
    kernel: Kernel = "alone"
    laws: Laws = ()


@dataclass(frozen=True)
class Fault:
    """What is wrong; ``old`` becomes ``new`` at ``place``, see ``plant``."""

    wrong: str
    place: str
    old: str
    new: str
    seen: Seen

    def __str__(self) -> str:
        return f"{self.seen.model} {self.seen.check} {self.seen.quantity}: {self.wrong}"


def faults_in(name: str) -> list[Fault]:
    """The rows of a file."""
    data = tomllib.loads((HERE / f"{name}.toml").read_text(encoding="utf-8"))
    return [
        Fault(wrong, data["inside"] + place, old, new, seen)
        for group in data["planted"]
        for seen in [_seen(**(data["usual"] | group["seen_by"]))]
        for wrong, place, old, new in group["faults"]
    ]


def _seen(laws: Mapping[str, str] | None = None, **more: Any) -> Seen:
    return Seen(**more, laws=tuple((laws or {}).items()))


def judge_guard(wrong: Iterable[str]) -> str:
    """The verdict of a guard; a test that fails shows the first thing that is wrong."""
    first = next(iter(wrong), None)
    if first is None:
        return "agree"
    print(first)
    return "differ"


def plant(patch: pytest.MonkeyPatch, place: str, old: str, new: str) -> None:
    """``old``, of which there is one, becomes ``new`` in a function or a text.

    place: ``module:name`` or ``module:owner.name``, of a class or of a table by key; or
    ``module:file.j2``, a template of the module that fills them in.
    """
    module_name, name = place.split(":")
    if name.endswith(".j2"):
        _plant_in_template(patch, import_module(module_name), name, old, new)
        return
    module = import_module(module_name)
    owner, _, attribute = name.rpartition(".")
    holder = getattr(module, owner) if owner else module
    if isinstance(holder, dict):
        (key,) = (key for key in holder if getattr(key, "__name__", key) == attribute)
        patch.setitem(holder, key, _replaced(holder[key], place, old, new))
        return
    original = getattr(holder, attribute)
    if isinstance(original, str):
        patch.setattr(holder, attribute, _replaced(original, place, old, new))
        return
    if isinstance(original, property) and original.fget is not None:
        changed = property(_changed(original.fget, module, owner, old, new))
        patch.setattr(holder, attribute, changed)
        return
    changed = _changed(inspect.unwrap(original), module, owner, old, new)
    patch.setattr(holder, attribute, changed)  # of a plug-in, too
    if not owner:
        _rebind(patch, [(original, changed)], ("crosscheck",))


def _plant_in_template(
    patch: pytest.MonkeyPatch, module: ModuleType, name: str, old: str, new: str
) -> None:
    """The module's templates with one changed."""
    usual = module.load_templates()
    source, _, _ = usual.loader.get_source(usual, name)
    changed = DictLoader({name: _replaced(source, name, old, new)})
    harmed = usual.overlay(loader=ChoiceLoader([changed, usual.loader]), cache_size=50)
    patch.setattr(module, "load_templates", lambda: harmed)


def _replaced(text: str, place: str, old: str, new: str) -> str:
    assert text.count(old) == 1, f"{place} has no single {old!r} to change"
    return text.replace(old, new)


def _changed(
    function: Callable[..., object], module: ModuleType, owner: str, old: str, new: str
) -> Callable[..., object]:
    source = textwrap.dedent(inspect.getsource(function))
    source = _replaced(source[source.index("def ") :], function.__qualname__, old, new)
    source = source.replace("super()", f"super({owner}, self)")
    flags = __future__.annotations.compiler_flag
    names: dict[str, Callable[..., object]] = {}
    exec(compile(source, f"<{module.__name__}, changed>", "exec", flags), vars(module), names)
    return names[function.__name__]


def _rebind(
    patch: pytest.MonkeyPatch,
    changes: Sequence[tuple[object, object]],
    packages: tuple[str, ...] = ("crosscheck.analytic", "crosscheck.models"),
) -> None:
    """Put what is changed wherever these packages have imported the original."""
    changed = {id(original): new for original, new in changes}
    for module in _modules(packages, len(sys.modules)):
        if changed.keys().isdisjoint(map(id, vars(module).values())):
            continue
        for name, value in list(vars(module).items()):
            if id(value) in changed:
                patch.setattr(module, name, changed[id(value)])


@lru_cache(maxsize=32)
def _modules(packages: tuple[str, ...], imported: int) -> list[ModuleType]:
    """The modules of packages among so many that are imported, which no other number has."""
    inside = tuple(f"{package}." for package in packages)
    return [
        module
        for name, module in list(sys.modules.items())
        if name in packages or name.startswith(inside)
    ]


def interpret(patch: pytest.MonkeyPatch, model: str, kernel: Kernel = "alone") -> None:
    """Replace compiled and remembered functions of a model by their Python originals."""
    load_model_class(model)  # a module first imported later would keep what is put in now
    engine = model.split(":")[0]
    packages = INTERPRETED.get(model) or INTERPRETED.get(engine, ())
    values = [
        value for module in _modules(packages, len(sys.modules)) for value in vars(module).values()
    ]
    wrapped = [
        value
        for value in values
        if getattr(value, "__module__", "").startswith(packages) and hasattr(value, "__wrapped__")
    ]
    _rebind(patch, [(value, inspect.unwrap(value)) for value in wrapped])
    if model == "exudyn:tree":
        loads = import_module(f"{TREE}.loads")
        patch.setattr(loads, "_entry", lambda function, *arguments: function)
    if model == "exudyn:bodies":
        contact = import_module(f"{BODIES}.contact")
        _rebind(patch, [(contact.push_bodies, contact.mesh_forces)])
    if engine == "analytic":
        kernels.keep_nothing(patch)
        kernels.choose(patch, kernel)
