"""Whether machine code does what a kernel's text says, translated as the translator stands."""

import ast
from ctypes import c_double, c_void_p
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from crosscheck.analytic.kernel import translate
from crosscheck.analytic.kernel.batch import (
    BLOCK_LANES,
    Batch,
    contiguous_table,
    make_aligned_zeros,
)
from crosscheck.analytic.kernel.machine import Code, compile_ir, target_machine
from crosscheck.analytic.kernel.program import Program, build_steps_program
from crosscheck.analytic.model import PhysicalModel
from crosscheck.models.loading import load_case
from tests.faults.planting import Laws, Seen
from tests.interpreted import addresses, fma, interpreted

FUSED_OR_NOT = """
def both(out: array, a, b, c):
    out[0] = a * b + c
    out[1] = fma(a, b, c)
"""


def same_bits(seen: Seen) -> str:
    """A step by machine code made from the text, and by Python; of one member or of several."""
    lanes = 1 if seen.kernel == "alone" else BLOCK_LANES
    program, work, given, right = by_python(seen.arm, seen.laws, lanes)
    code = Code(
        compile_ir(translate.translate_to_ir(program.text, lanes), target_machine(1), 1),
        dict(program.functions),
    )
    made, out = make_aligned_zeros(1, right.size)[0], np.zeros((1, right.size))
    made[:] = work
    code["advance"](made.ctypes.data, *addresses((*given, out)))
    return "agree" if np.array_equal(made, right, equal_nan=True) else "differ"


@lru_cache
def by_python(
    arm: str, laws: Laws, lanes: int
) -> tuple[Program, np.ndarray, tuple[Any, ...], np.ndarray]:
    """A kernel, what it works on, its other arguments, and what Python leaves of a step.

    Of members that move, each its own way, out of contact and in it.
    """
    blunt = (
        ["arm.joints.*.*_mesh.tanh_sharpness_per_m=1e4"] if ("dead_zone", "tanh") in laws else []
    )
    case = load_case(arm, "pd", dict(laws), ["scenario.record_every=1", *blunt])
    batch, draw = Batch([PhysicalModel(*case)] * lanes, lanes), np.random.default_rng(2)
    names = batch.structure.coordinates
    state = batch.work.reshape(-1, lanes)[: 2 * len(names)]
    angular = np.array([name.startswith("theta") for name in names] * 2)
    numbers = batch.work.reshape(-1, lanes)[batch.program.leading_rows :]
    numbers *= 1 + 1e-3 * np.arange(lanes)
    state[:] = np.where(angular, 1.0, 1e-4)[:, None] * draw.normal(size=state.shape)
    batch.work.reshape(-1, lanes)[len(state) : 2 * len(state)] = state  # of the first stage
    program = build_steps_program(batch.structure, batch.models[0].equations.record_map(), lanes)
    times, torques = contiguous_table(batch.models[0].drive)
    given = (1, 700, 1, 1, 1e-5, times, torques, times.size, np.zeros(len(torques)))
    work = batch.work.copy().reshape(-1)
    right = work.copy()
    with np.errstate(all="ignore"):
        interpreted(program)["advance"](right, *given, np.zeros((1, right.size)))
    return program, work, given, right


def fused_as_written(seen: Seen) -> str:
    """A product is fused with a sum where the text says so, and only there."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(translate._Function, "_function_call", _unfused)
        code = Code(
            compile_ir(translate.translate_to_ir(FUSED_OR_NOT, 1), target_machine(2), 2),
            {"both": (c_void_p, c_double, c_double, c_double)},
        )
    out, right = np.zeros(2), []
    for a, b, c in np.random.default_rng(1).normal(size=(50, 3)).tolist():
        code["both"](out.ctypes.data, a, b, c)
        right.append(out.tolist() == [a * b + c, fma(a, b, c)])
    return "agree" if all(right) else "differ"


def _unfused(self: Any, name: str, values: list[translate.Value]) -> translate.Value:
    """What stands for ``fma`` where it is not translated as such."""
    assert name == "fma"
    a, b, c = values
    return self._binary(ast.Add(), self._binary(ast.Mult(), a, b), c)
