"""Planting faults: one function of a model's own code with a piece of its text changed.

The checks are handed the harmed model and an unharmed one from another engine. Compiled and
remembered functions of the harmed model are replaced by their Python originals, so that a change
reaches everything that uses it; the control run without a fault is made in the same way.
"""

from __future__ import annotations
import __future__

import inspect
import sys
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from importlib import import_module
from types import ModuleType
from typing import NamedTuple

import pytest

from crosscheck.checks.trajectories import Pair
from crosscheck.findings import Finding
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.interface import Model
from crosscheck.models.loading import Case, load_arm
from crosscheck.planning.plan import nudged
from crosscheck.registry import MODELS, build, model_class
from tests.faults import kernels
from tests.faults.kernels import Kernel
from tests.judged import compare_states, energy_over_run, invariants, same_step

STATES, SEED = 5, 0
PACKAGES = {
    "analytic": ("crosscheck.analytic",),
    "pinocchio": (),
    "exudyn": (
        "crosscheck.models.exudyn.tree.mesh",
        "crosscheck.models.exudyn.tree.tree",
        "crosscheck.models.exudyn.tree.laws",
        "crosscheck.models.exudyn.tree.loads",
        "crosscheck.models.exudyn.tree.parts",
        "crosscheck.models.exudyn.tree.stiffness",
    ),
}
Plant = Callable[[pytest.MonkeyPatch], None]
Laws = tuple[tuple[str, str], ...]

MASS, BIAS = "states/mass_matrix", "states/bias"
FORCE, ACCELERATION = "states/generalized_force", "states/acceleration"
OMEGA_T, EQ13 = (("phase", "omega_t"),), (("ring_rate", "eq13"),)
UNLIKE, DIRECT = "three-unlike", "direct-between"  # arms of the second version
SHIFTED_TABLE = "(*law.stiffness_N_per_m[1:], law.stiffness_N_per_m[1])"
TANH, CONTACT = (("dead_zone", "tanh"),), (("damping", "contact"),)


class Setup(NamedTuple):
    """Switches, drive, arm and kernel of the experiment in which a fault is sought; see Fault."""

    laws: Laws = ()
    drive: str = "pd"
    arm: str = "probe"
    kernel: Kernel = "alone"

    @property
    def case(self) -> Case:
        """The experiment."""
        arm = load_arm(self.arm)
        scenario = probe_scenario(self.drive, len(arm.joints))
        return Case(arm, scenario, usual_switches(arm, **dict(self.laws)))


class Fault(NamedTuple):
    """A fault and the check that must see it.

    red_check: kind and quantity of the check, as ``states/bias`` or ``same-step/theta``. laws:
    switches, drive a name in DRIVES and arm a built-in one, on which the fault can be seen;
    kernel: of analytic:physical's runs.
    """

    name: str
    plant: Plant
    red_check: str
    laws: Laws = ()
    drive: str = "pd"
    arm: str = "probe"
    kernel: Kernel = "alone"

    @property
    def setup(self) -> Setup:
        """In which it is planted."""
        return Setup(self.laws, self.drive, self.arm, self.kernel)


def edit(place: str, old: str, new: str) -> Plant:
    """``old`` becomes ``new`` in the function ``module:name`` or ``module:Class.name``."""

    def plant(patch: pytest.MonkeyPatch) -> None:
        module_name, name = place.split(":")
        module = import_module(module_name)
        owner, _, attribute = name.rpartition(".")
        holder = getattr(module, owner) if owner else module
        original = getattr(holder, attribute)
        changed = _changed(inspect.unwrap(original), module, owner, old, new)
        if owner:
            patch.setattr(holder, attribute, changed)
        else:
            patch.setattr(module, attribute, changed)  # of a plug-in, too
            _rebind(patch, [(original, changed)])

    return plant


def _changed(
    function: Callable[..., object], module: ModuleType, owner: str, old: str, new: str
) -> Callable[..., object]:
    source = textwrap.dedent(inspect.getsource(function))
    source = source[source.index("def ") :]
    assert source.count(old) == 1, f"{function.__qualname__} has no single {old!r} to change"
    source = source.replace(old, new).replace("super()", f"super({owner}, self)")
    flags = __future__.annotations.compiler_flag
    names: dict[str, Callable[..., object]] = {}
    exec(compile(source, f"<{module.__name__}, changed>", "exec", flags), vars(module), names)
    return names[function.__name__]


def _rebind(patch: pytest.MonkeyPatch, changes: Sequence[tuple[object, object]]) -> None:
    """Put what is changed wherever the models have imported the original."""
    changed = {id(original): new for original, new in changes}
    for module in _modules(("crosscheck.analytic", "crosscheck.models")):
        for name, value in list(vars(module).items()):
            if id(value) in changed:
                patch.setattr(module, name, changed[id(value)])


def _modules(packages: tuple[str, ...]) -> list[ModuleType]:
    inside = tuple(f"{package}." for package in packages)
    return [
        module
        for name, module in list(sys.modules.items())
        if name in packages or name.startswith(inside)
    ]


def interpret(patch: pytest.MonkeyPatch, model: str, kernel: Kernel = "alone") -> None:
    """Replace compiled and remembered functions of a model by their Python originals."""
    model_class(model)  # a module first imported later would keep what is put in now
    packages = PACKAGES[model.split(":")[0]]
    values = [value for module in _modules(packages) for value in vars(module).values()]
    wrapped = [
        value
        for value in values
        if getattr(value, "__module__", "").startswith(packages) and hasattr(value, "__wrapped__")
    ]
    _rebind(patch, [(value, inspect.unwrap(value)) for value in wrapped])
    if "crosscheck.models.exudyn.tree.loads" in packages:
        loads = import_module("crosscheck.models.exudyn.tree.loads")
        patch.setattr(loads, "_entry", lambda function, *arguments: function)
    if "crosscheck.analytic" in packages:
        kernels.keep_nothing(patch)
        kernels.choose(patch, kernel)


def probe_arm() -> Arm:
    """An arm on which no two numbers are equal that a fault might confuse."""
    return load_arm("probe")


DRIVES = {
    "pd": {
        "kind": "pd",
        "target_rad": [0.5, -0.3, 0.2],
        "proportional_N_m_per_rad": [1000.0, 800.0, 500.0],
        "derivative_N_m_s_per_rad": [400.0, 300.0, 60.0],
    },
    "sinusoid": {
        "kind": "sinusoid",
        "amplitude_N_m": [200.0, 150.0, 40.0],
        "rate_rad_per_s": [50.0, 70.0, 90.0],
        "argument": "time",
    },
    "root": {
        "kind": "sinusoid",
        "amplitude_N_m": [200.0, 150.0, 40.0],
        "rate_rad_per_s": [50.0, 70.0, 90.0],
        "argument": "sqrt_time",
    },
    "table": {  # of three joints
        "kind": "table",
        "time_s": [0.0, 0.7e-3, 2e-3],
        "torque_N_m": [[0.0, 300.0, -200.0], [100.0, -100.0, 400.0], [30.0, 0.0, -50.0]],
    },
}
START = {
    "theta_rad": [0.3, -0.8, 0.5],
    "theta_dot_rad_per_s": [0.6, -0.9, 0.7],
    "sun_planet_offset_m": [2e-6, 5e-6, 1e-6],
    "planet_ring_offset_m": [-3e-6, 4e-6, 2e-6],
}


def probe_scenario(drive: str, joints: int = 2) -> Scenario:
    """200 steps from a start in motion, off centre in every mesh, of up to three joints."""

    def of_joints(fields: Mapping[str, object]) -> dict[str, object]:
        return {k: v[:joints] if isinstance(v, list) else v for k, v in fields.items()}

    return Scenario.model_validate(
        {
            "schema_version": 1,
            "name": "probe",
            "duration_s": 2e-3,
            "step_s": 1e-5,
            "record_every": 10,
            "start": of_joints(START),
            "drive": of_joints(DRIVES[drive]),
        }
    )


def probe_model(name: str, setup: Setup) -> Model:
    """The model in the experiment in which faults are sought."""
    return build(name, *setup.case)


unharmed = lru_cache(probe_model)  # never handed out with a fault planted in it


@lru_cache
def _unharmed_runs(name: str, setup: Setup) -> Pair:
    """A run, and that from a start one rounding away."""
    case = setup.case
    return Pair(*(build(name, *of).simulate() for of in (case, nudged(case))))


def verdict(fault: Fault, harmed: str, partner: str) -> str:
    """Verdict of the fault's check on two models, with whatever is planted in the first."""
    kind, quantity = fault.red_check.split("/")
    start = f"{kind}/planted/{quantity}/"
    (finding,) = [
        finding
        for finding in _findings(fault, harmed, partner)
        if finding.id.startswith(start) and harmed in finding.id
    ]
    return finding.verdict


def _findings(fault: Fault, harmed: str, partner: str) -> Iterator[Finding]:
    model = probe_model(harmed, fault.setup)
    kind, quantity = fault.red_check.split("/")
    if kind == "states":
        both = {harmed: model, partner: unharmed(partner, fault.setup)}
        models = [both[name] for name in MODELS if name in both]  # as in a cross-check
        yield from compare_states("planted", models, [quantity], STATES, SEED)
    elif kind == "same-step":
        pair, run = _unharmed_runs(partner, fault.setup), model.simulate()
        yield from same_step("planted", fault.setup.case, run, pair.run, pair, [quantity])
    elif fault.red_check == "invariants/energy":
        yield from energy_over_run("planted", model.reference(1e-10))
    else:
        yield from invariants("planted", [model], STATES, SEED)


@lru_cache
def _control(harmed: str, partner: str, red_check: str, setup: Setup) -> str:
    fault = Fault("none", lambda patch: None, red_check, *setup)
    with pytest.MonkeyPatch.context() as patch:
        interpret(patch, harmed, setup.kernel)
        return verdict(fault, harmed, partner)


def assert_seen(fault: Fault, harmed: str, partner: str) -> None:
    """The check agrees without the fault and differs with it; no fault merely raises."""
    assert _control(harmed, partner, fault.red_check, fault.setup) == "agree"
    with pytest.MonkeyPatch.context() as patch:
        interpret(patch, harmed, fault.kernel)
        fault.plant(patch)
        assert verdict(fault, harmed, partner) == "differ"
