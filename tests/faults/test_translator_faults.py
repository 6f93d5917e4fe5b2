"""Faults in the translation of a kernel's text: machine code no longer does what the text says."""

from __future__ import annotations

import ast
from ctypes import c_double, c_void_p
from typing import Any, NamedTuple

import numpy as np
import pytest

from crosscheck.analytic.kernel import translate
from crosscheck.analytic.kernel.batch import WIDE, Batch, contiguous_table
from crosscheck.analytic.kernel.machine import Code, compiled, machine
from crosscheck.analytic.kernel.program import steps_program
from crosscheck.analytic.model import PhysicalModel
from crosscheck.models.loading import load_case
from tests.faults.faults import Plant, edit
from tests.interpreted import addresses, fma, interpreted

ARMS = {
    "tanh": ("paper-labelled", {"dead_zone": "tanh", "phase": "omega_t"}),
    "contact": ("paper-labelled", {"damping": "contact"}),
    "table": ("direct-between", {"mesh_work": "conservative"}),
}
STEPS = 1


class Fault(NamedTuple):
    """A fault of the translator, and on which arm's kernel it shows."""

    name: str
    plant: Plant
    arm: str = "contact"
    lanes: int = 1


def change(function: str, old: str, new: str) -> Plant:
    return edit(f"crosscheck.analytic.kernel.translate:_Function.{function}", old, new)


def item(table: str, key: type, value: str) -> Plant:
    def plant(patch: pytest.MonkeyPatch) -> None:
        patch.setitem(getattr(translate, table), key, value)

    return plant


CONTRACTED = 'operations[type(op)] + " contract" * (operations is _FLOAT)'
SKIPPED = "self._named(name) if self.straight else self._expression(changed)"
POSITIVE = 'f"fadd {self._type(value.kind)} {value.text}, zeroinitializer"'
FAULTS = [
    Fault("operands change places", change("_binary", "{a.text}, {b.text}", "{b.text}, {a.text}")),
    Fault("a sum for a difference", item("_FLOAT", ast.Sub, "fadd")),
    Fault("branch lost", change("_select", "{kind} {yes.text}, {", "{kind} {no.text}, {")),
    Fault("comparison turned round", item("_ORDERED", ast.Gt, "olt")),
    Fault(
        "sign lost", change("_negative", 'f"fneg {self._type(value.kind)} {value.text}"', POSITIVE)
    ),
    Fault("magnitude lost", change("_call", '"abs": "fabs"', '"abs": "sqrt"')),
    Fault("change in place skipped", change("_statement", "self._expression(changed)", SKIPPED)),
    Fault(
        "numbers in single precision",
        edit(
            "crosscheck.analytic.kernel.translate:_constant",
            'struct.pack("<d", number)',
            'struct.pack("<d", struct.unpack("<f", struct.pack("<f", number))[0])',
        ),
    ),
    Fault(
        "power of two off by one",
        change("_power_of_two", "EXPONENT_BIAS <<", "(EXPONENT_BIAS + 1) <<"),
        "tanh",
    ),
    Fault(
        "row of the first lane", change("_pick", "self.lanes + lane", "self.lanes"), "table", WIDE
    ),
    Fault(
        "index of the first lane",
        change("_pick", "{places}, i64 {lane}", "{places}, i64 0"),
        "table",
        WIDE,
    ),
    Fault(
        "lanes written in turn",
        change("_pick", "{number}, i64 {lane}", "{number}, i64 {self.lanes - 1 - lane}"),
        "table",
        WIDE,
    ),
]


def batch_of(arm: str, lanes: int) -> Batch:
    """Members that move, each its own way, out of contact and in it."""
    name, switches = ARMS[arm]
    blunt = ["arm.joints.*.tanh_sharpness_per_m=1e4"] if "dead_zone" in switches else []
    case = load_case(name, "pd", switches, ["scenario.record_every=1", *blunt])
    batch, draw = Batch([PhysicalModel(*case)] * lanes, lanes), np.random.default_rng(2)
    n = len(batch.structure.coordinates)
    state = batch.work.reshape(-1, lanes)[: 2 * n]
    angular = np.array([name.startswith("theta") for name in batch.structure.coordinates] * 2)
    numbers = batch.work.reshape(-1, lanes)[batch.program.before :]
    numbers *= 1 + 1e-3 * np.arange(lanes)
    state[:] = np.where(angular, 1.0, 1e-4)[:, None] * draw.normal(size=state.shape)
    return batch


def same_bits(arm: str, lanes: int) -> bool:
    """Whether machine code made now does what the text says."""
    batch = batch_of(arm, lanes)
    program = steps_program(batch.structure, lanes)
    code = Code(
        compiled(translate.ir_of(program.text, lanes), machine(1), 1), dict(program.functions)
    )
    right, (times, torques) = batch.work.copy().reshape(-1), contiguous_table(batch.models[0].drive)
    table = times, torques, times.size, np.zeros(len(torques))
    given = (1, 700, STEPS, 1, 1e-5, *table, np.zeros((STEPS, right.size)))
    with np.errstate(all="ignore"):
        interpreted(program)["advance"](right, *given)
    code["advance"](batch.work.ctypes.data, *addresses(given))
    return np.array_equal(batch.work.reshape(-1), right, equal_nan=True)


@pytest.mark.parametrize("lanes", [1, WIDE])
@pytest.mark.parametrize("arm", ARMS)
def test_without_a_fault_the_bits_are_the_texts(arm, lanes):
    assert same_bits(arm, lanes)


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_fault_changes_them(fault: Fault):
    with pytest.MonkeyPatch.context() as patch:
        fault.plant(patch)
        assert not same_bits(fault.arm, fault.lanes)


FUSED_OR_NOT = """
def both(out: array, a, b, c):
    out[0] = a * b + c
    out[1] = fma(a, b, c)
"""


def fused_as_written() -> bool:
    """Whether a product is fused with a sum where the text says so, and only there."""
    code = Code(
        compiled(translate.ir_of(FUSED_OR_NOT, 1), machine(2), 2),
        {"both": (c_void_p, c_double, c_double, c_double)},
    )
    out, right = np.zeros(2), []
    for a, b, c in np.random.default_rng(1).normal(size=(50, 3)).tolist():
        code["both"](out.ctypes.data, a, b, c)
        right.append(out.tolist() == [a * b + c, fma(a, b, c)])
    return all(right)


def test_products_are_fused_as_written():
    assert fused_as_written()


@pytest.mark.parametrize(
    "plant",
    [
        change("_binary", "operations[type(op)]", CONTRACTED),
        change("_call", '"abs" | "sqrt" | "fma"', '"abs" | "sqrt"'),
    ],
    ids=["any sum of products fused", "no product fused"],
)
def test_a_fault_of_fusing_is_seen(plant: Plant):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(translate._Function, "_function_call", unfused)
        plant(patch)
        assert not fused_as_written()


def unfused(self: Any, name: str, values: list[translate.Value]) -> translate.Value:
    """What stands for ``fma`` where it is not translated as such."""
    assert name == "fma"
    a, b, c = values
    return self._binary(ast.Add(), self._binary(ast.Mult(), a, b), c)
