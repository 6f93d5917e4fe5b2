"""Machine code is kept in the user's cache folder, named after all that it depends on."""

import errno
import os
import subprocess
import sys
import time
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
import pytest

from crosscheck.analytic.kernel import machine as module
from crosscheck.analytic.kernel.batch import Batch
from crosscheck.analytic.kernel.machine import Code, compile_ir, target_machine
from crosscheck.analytic.kernel.translate import translate_to_ir
from crosscheck.analytic.model import PhysicalModel
from crosscheck.models.loading import load_case
from tests.interpreted import addresses
from tests.tool.code import OTHER, add

pytestmark = pytest.mark.system


@pytest.fixture
def folder(cache: Path) -> Path:
    """Where machine code is kept."""
    return cache / "machine-code"


def test_an_object_of_another_name_is_not_run(folder):
    add()
    (path,) = folder.iterdir()
    other = path.read_bytes()
    assert add(OTHER) == -1.0
    assert len(list(folder.iterdir())) == 2
    for each in folder.iterdir():
        each.write_bytes(other)
    assert (add(), add(OTHER)) == (5.0, -1.0)


@pytest.mark.parametrize("name", [".", "machine-code"])
def test_where_no_folder_can_be_nothing_is_kept(folder, name):
    taken = folder.parent / name
    taken.parent.mkdir(parents=True, exist_ok=True)
    if taken.exists():
        taken.rmdir()
    taken.write_text("in the way")
    assert add() == 5.0
    assert taken.read_text() == "in the way"


def test_a_full_disk_leaves_no_half_object(folder, monkeypatch):
    def full(self: Path, data: bytes) -> int:
        os.close(os.open(self, os.O_CREAT | os.O_WRONLY))
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    assert add() == 5.0
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("is_read", [False, True])
def test_what_is_not_used_for_long_goes(folder, is_read):
    add()
    (old,) = folder.iterdir()
    long_ago = time.time() - 86400 * (module.KEPT_DAYS + 1)
    os.utime(old, (long_ago, long_ago))
    if is_read:  # which counts as use
        add()
    add(OTHER)
    assert (old in folder.iterdir()) == is_read


def test_the_oldest_goes_beyond_the_size_that_is_kept(folder, monkeypatch):
    add()
    (old,) = folder.iterdir()
    before = time.time() - 60
    os.utime(old, (before, before))
    monkeypatch.setattr(module, "KEPT_BYTES", old.stat().st_size + 10)
    add(OTHER)
    assert old not in folder.iterdir()
    assert len(list(folder.iterdir())) == 1


def test_processes_that_make_the_same_object_at_once(folder):
    script = "from tests.tool.code import add\nassert add() == 5.0\n"
    running = [subprocess.Popen([sys.executable, "-c", script]) for _ in range(3)]
    assert [process.wait() for process in running] == [0, 0, 0]
    assert [path.suffix for path in folder.iterdir()] == [".o"]


def kernel_steps(batch: Batch, target: llvm.TargetMachine, level: int) -> np.ndarray:
    """All rows after some steps, by machine code for a processor."""
    program = batch.program
    code = Code(
        compile_ir(translate_to_ir(program.text, program.lanes), target, level),
        dict(program.functions),
    )
    work, table = batch.work, (np.zeros(1), np.zeros(2), 1, np.zeros(2))
    before, out = work.copy(), np.zeros((20, work.size))
    code["advance"](work.ctypes.data, 1, 0, 20, 10, 1e-5, *addresses(table), out.ctypes.data)
    found, work[:] = work.copy(), before
    return found


@pytest.mark.skipif(
    not llvm.get_process_triple().startswith("x86_64"), reason="names x86 processors"
)
@pytest.mark.parametrize("lanes", [1, 8])
def test_every_processor_and_level_makes_the_same_bits(lanes):
    case = load_case("planets-apart", "pd", {"phase": "omega_t"})
    batch = Batch([PhysicalModel(*case)] * lanes, lanes)
    right = kernel_steps(batch, target_machine(2), 2)
    assert np.isfinite(right).all()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    for name in ("x86-64", "x86-64-v3"):  # without fused operations in hardware, and with AVX2
        other = target.create_target_machine(cpu=name, features="", opt=2, jit=True)
        np.testing.assert_array_equal(kernel_steps(batch, other, 2), right)
    for level in (0, 1):
        np.testing.assert_array_equal(kernel_steps(batch, target_machine(level), level), right)


@pytest.mark.parametrize(
    ("triple", "number"), [("aarch64-unknown-linux-gnu", 183), ("x86_64-unknown-linux-gnu", 62)]
)
def test_objects_can_be_made_for_other_machines(triple, number):
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    other = llvm.Target.from_triple(triple).create_target_machine(opt=2)
    case = load_case("paper-labelled", "pd", {"dead_zone": "tanh"})
    program = Batch([PhysicalModel(*case)]).program
    data = compile_ir(translate_to_ir(program.text, 8), other, 2)
    assert data[:4] == b"\x7fELF"
    assert int.from_bytes(data[18:20], "little") == number  # e_machine
    assert llvm.ObjectFileRef.from_data(data).sections()
