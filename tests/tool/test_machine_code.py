"""Machine code is kept in the user's cache folder, named after all that it depends on."""

import errno
import hashlib
import os
import subprocess
import sys
import time
from ctypes import c_double, c_void_p
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
import pytest

from crosscheck.analytic.kernel import machine as module
from crosscheck.analytic.kernel.batch import Batch
from crosscheck.analytic.kernel.machine import Code, compile_ir, load_machine_code, target_machine
from crosscheck.analytic.kernel.translate import translate_to_ir
from crosscheck.analytic.model import PhysicalModel
from crosscheck.models.directories import prepare_code_folder
from crosscheck.models.loading import load_case
from tests.interpreted import addresses
from tests.obstacles import OBSTACLES
from tests.processes import command_line
from tests.tool.test_cache import NOT_PRIVATE, another_users

pytestmark = pytest.mark.system

SHORT = ("simulate", "paper-labelled", "--model", "analytic:links", "--scenario", "pd")
SUM = 'def add(out: array, a, b):\n    """a + b."""\n    out[0] = a + b\n'
OTHER = SUM.replace("a + b\n", "a - b\n")


def add(text: str = SUM) -> float:
    """What kept or new machine code makes of 2 and 3."""
    out = np.zeros(1)
    data = load_machine_code(text, 1, 1)
    Code(data, {"add": (c_void_p, c_double, c_double)})["add"](out.ctypes.data, 2.0, 3.0)
    return float(out[0])


@pytest.fixture
def folder(cache: Path) -> Path:
    """Where machine code is kept."""
    return cache / "machine-code"


def test_an_object_is_kept_in_a_private_folder(folder):
    assert add() == 5.0
    (path,) = folder.iterdir()
    assert path.suffix == ".o"
    assert folder.stat().st_mode & 0o777 == 0o700


def test_a_kept_object_is_not_made_again(folder, monkeypatch):
    add()
    monkeypatch.setattr(module, "compile_ir", None)
    assert add() == 5.0


def test_another_text_is_another_object(folder):
    assert (add(), add(OTHER)) == (5.0, -1.0)
    assert len(list(folder.iterdir())) == 2


@pytest.mark.parametrize(
    ("owner", "name", "other"),
    [
        (module, "_processor", lambda: ("x86-64", "")),
        (module, "_translator", lambda: ("another", "code")),
        (module.llvmlite, "__version__", "999"),
    ],
    ids=["processor", "translator", "compiler"],
)
def test_another_processor_compiler_or_translator_is_another_object(
    folder, monkeypatch, owner, name, other
):
    add()
    monkeypatch.setattr(owner, name, other)
    add()
    assert len(list(folder.iterdir())) == 2


@pytest.mark.parametrize("damage", ["empty", "half", "flipped", "longer", "another"])
def test_a_damaged_object_is_made_again_and_not_run(folder, damage, capsys):
    add()
    (path,) = folder.iterdir()
    sound = path.read_bytes()
    flipped = sound[:-9] + bytes([sound[-9] ^ 1]) + sound[-8:]
    harmed = {
        "empty": b"",
        "half": sound[: len(sound) // 2],
        "flipped": flipped,
        "longer": sound + b"\0",
        "another": b"\x7fELF of something else",
    }
    path.write_bytes(harmed[damage])
    assert add() == 5.0
    assert path.read_bytes() == sound
    said = capsys.readouterr().err
    assert said == f"crosscheck: {path}: does not fit: damaged; it is made again\n"


@pytest.mark.parametrize("case", NOT_PRIVATE)
def test_an_object_that_is_not_the_users_own_is_not_run(folder, case, capsys):
    spoil, said = NOT_PRIVATE[case]
    if spoil is another_users and os.geteuid() != 0:
        pytest.skip("only root can give files away")
    add()
    (path,) = folder.iterdir()
    path.write_bytes(seal(path, compile_ir(translate_to_ir(OTHER, 1), target_machine(1), 1)))
    assert add() == -1.0  # a kept object is believed by its checksum
    spoil(path)
    assert add() == 5.0
    assert (
        capsys.readouterr().err == f"crosscheck: {path}: does not fit: {said}; it is made again\n"
    )
    assert add() == 5.0
    assert capsys.readouterr().err == ""


def seal(path: Path, data: bytes) -> bytes:
    """An object as it is kept."""
    return hashlib.sha256(path.name.encode() + data).digest() + data


def test_an_object_of_another_name_is_not_run(folder):
    add()
    (path,) = folder.iterdir()
    other = path.read_bytes()
    add(OTHER)
    for each in folder.iterdir():
        each.write_bytes(other)
    assert (add(), add(OTHER)) == (5.0, -1.0)


def test_objects_in_a_folder_that_others_could_write_are_removed(folder):
    add()
    (path,) = folder.iterdir()
    path.write_bytes(seal(path, compile_ir(translate_to_ir(OTHER, 1), target_machine(1), 1)))
    folder.chmod(0o777)
    prepare_code_folder.cache_clear()
    assert add() == 5.0
    assert folder.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("what", ["pipe", "folder", "loop"])
def test_what_is_no_file_is_no_object(folder, what, capsys):
    add()
    (path,) = folder.iterdir()
    path.unlink()
    OBSTACLES[what](path)
    assert add() == 5.0
    assert capsys.readouterr().err.count("\n") == 1


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
    script = "from tests.tool.test_machine_code import add\nassert add() == 5.0\n"
    running = [subprocess.Popen([sys.executable, "-c", script]) for _ in range(3)]
    assert [process.wait() for process in running] == [0, 0, 0]
    assert [path.suffix for path in folder.iterdir()] == [".o"]


def test_a_run_needs_no_cache_folder(tmp_path):
    env = {"HOME": "/dev/null/home", "XDG_CACHE_HOME": "", "TMPDIR": str(tmp_path)}
    out = tmp_path / "run.nc"
    answer = command_line(*SHORT, "--t-end", "0.0002", "--out", out, env=env)
    assert (answer.returncode, answer.stderr) == (0, "")
    assert out.exists()
    assert not list(tmp_path.glob("geararm-*"))  # a folder for one process goes with it


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
