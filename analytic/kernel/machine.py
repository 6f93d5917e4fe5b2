"""A kernel's text to machine code, kept between runs in a folder of the user's own.

A kept object is named after all that it depends on: the text, the code that translates it, the
versions of LLVM and of its Python binding, and the processor with its features.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding as llvm

from crosscheck.analytic.kernel import translate
from crosscheck.analytic.kernel.text import fusion
from crosscheck.analytic.kernel.translate import translate_to_ir
from crosscheck.models.directories import prepare_code_folder, read_sealed, seal

FOLDER = "machine-code"
KEPT_DAYS, KEPT_BYTES = 60, 256 * 2**20  # since its last use; all objects together


class Code:
    """Functions of an object file, called by their names.

    A pointer is an address, an int; arguments are checked by nobody.
    """

    def __init__(self, data: bytes, arguments: dict[str, Sequence[Any]]) -> None:
        # An engine for each object, so that names do not clash. It owns its target machine.
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target_machine(0))
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(data))
        self._engine.finalize_object()
        self._functions = {
            name: self._function(name, argument_types) for name, argument_types in arguments.items()
        }

    def _function(self, name: str, argument_types: Sequence[Any]) -> Callable[..., None]:
        function = ctypes.CFUNCTYPE(None, *argument_types)(self._engine.get_function_address(name))
        function.engine = self._engine  # type: ignore[attr-defined]  # which goes with the last one
        return function

    def __getitem__(self, name: str) -> Callable[..., None]:
        return self._functions[name]


def load_machine_code(text: str, lanes: int, level: int) -> bytes:
    """Object file of a kernel's text, from the cache folder or made and left there.

    Without a folder it is made alone. level: of optimisation, 0 to 3.
    """
    name = _digest(text, lanes, level)
    try:
        path = prepare_code_folder(FOLDER) / f"{name}.o"
    except OSError:
        return compile_ir(translate_to_ir(text, lanes), target_machine(level), level)
    object_file = read_sealed(path, KEPT_BYTES)
    if object_file is None:
        object_file = compile_ir(translate_to_ir(text, lanes), target_machine(level), level)
        _keep(path, object_file)
    else:
        with suppress(OSError):  # it has been used
            os.utime(path)
    return object_file


def compile_ir(ir: str, machine: llvm.TargetMachine, level: int) -> bytes:
    """Object file of IR for a machine."""
    module = llvm.parse_assembly(ir)
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    module.verify()
    # Most of it is straight-line code without a redundant line, its lanes vectors already: loops'
    # variables leave memory, and no other pass makes it faster.
    if level:
        passes = llvm.create_new_module_pass_manager()
        passes.add_sroa_pass()
        tuning = llvm.create_pipeline_tuning_options()
        passes.run(module, llvm.create_pass_builder(machine, tuning))
    return machine.emit_object(module)


def target_machine(level: int) -> llvm.TargetMachine:
    """This machine's own processor, with all that it can do."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    name, features = _processor()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    return target.create_target_machine(
        cpu=name, features=features, opt=level, reloc="default", codemodel="jitdefault", jit=True
    )


@lru_cache
def _processor() -> tuple[str, str]:
    """Name and features of this machine's processor."""
    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


@lru_cache
def _translator() -> tuple[str, ...]:
    """Source texts of the code that makes an object of a text."""
    files = __file__, translate.__file__, fusion.__file__
    return tuple(Path(file).read_text(encoding="utf-8") for file in files)


def _digest(text: str, lanes: int, level: int) -> str:
    made_by = llvmlite.__version__, str(llvm.llvm_version_info), llvm.get_process_triple()
    parts = str(lanes), str(level), text, *_translator(), *made_by, *_processor()
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]


def _keep(path: Path, data: bytes) -> None:
    """Keep a file, in place at once as others may be reading it; not where the folder is full."""
    draft = path.with_suffix(f".{os.getpid()}.draft")
    try:
        draft.touch(0o600, exist_ok=False)
        draft.write_bytes(seal(path, data))
        draft.replace(path)
    except OSError:
        with suppress(OSError):
            draft.unlink(missing_ok=True)
    _sweep(path.parent)


def _sweep(folder: Path) -> None:
    """Remove what was not used for long, and the oldest beyond the size that is kept."""
    with suppress(OSError):
        states = [(path.stat(), path) for path in folder.iterdir()]
        newest_first = sorted(states, key=lambda each: each[0].st_mtime, reverse=True)
        oldest, size = time.time() - 86400 * KEPT_DAYS, 0
        for state, path in newest_first:
            size += state.st_size
            if size > KEPT_BYTES or state.st_mtime < oldest:
                path.unlink(missing_ok=True)
