"""``python -m benchmarks.suite.assembly``: what the ensemble kernel's stages were compiled to.

Counts instructions on the widest vectors of an x86 processor, and those of them that touch memory.
"""

from __future__ import annotations

import os
import re
import tempfile
from typing import Any

from analytic.fast.batch import WIDE, Batch
from benchmarks.suite.cases import long_run
from benchmarks.suite.lanes import COUNTED, members_of

STEPS = 100
VECTOR = r"%[zy]mm\d+"
KINDS = {
    "stores": re.compile(rf"vmov\w+\s+{VECTOR},.*\("),
    "loads": re.compile(rf"vmov\w+\s+[^%].*\(.*{VECTOR}"),
    "with a number from memory": re.compile(rf"v(?!mov)\w+\s.*\(.*{VECTOR}"),
    "divisions": re.compile(r"vdiv"),
}


def main() -> None:
    """Of the paper's arm, lumped and free; compiled anew, for kept kernels have no text."""
    with tempfile.TemporaryDirectory() as place:
        os.environ["XDG_CACHE_HOME"] = place
        for counted in COUNTED:
            batch = Batch(members_of(long_run(2, counted, STEPS), WIDE))
            batch.advance(1, STEPS)
            for function in vars(batch.module).values():
                if hasattr(function, "inspect_asm") and function.signatures:
                    print(f"{counted}, {_counts(function)}")


def _counts(function: Any) -> str:
    (text,) = function.inspect_asm().values()
    vector = [line.strip() for line in text.splitlines() if re.search(VECTOR, line)]
    found = {name: sum(bool(kind.match(line)) for line in vector) for name, kind in KINDS.items()}
    told = ", ".join(f"{count} {name}" for name, count in found.items())
    return f"{function.py_func.__name__}: {len(vector)} vector instructions, {told}"


if __name__ == "__main__":
    main()
