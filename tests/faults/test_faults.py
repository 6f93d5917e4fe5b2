"""Every planted fault turns its check red, and without it the check is green."""

from functools import lru_cache

import pytest

from tests.faults.checks import CHECKS, COMPILED
from tests.faults.planting import HERE, Seen, faults_in, interpret, plant

FILES = sorted(file.stem for file in HERE.glob("*.toml"))
FAULTS = [fault for name in FILES for fault in faults_in(name)]


@lru_cache
def without_fault(seen: Seen) -> str:
    """The check's verdict."""
    with pytest.MonkeyPatch.context() as patch:
        prepare(patch, seen)
        return CHECKS[seen.check](seen)


def prepare(patch: pytest.MonkeyPatch, seen: Seen) -> None:
    """What is compiled can be changed."""
    if seen.check not in COMPILED:
        interpret(patch, seen.model, seen.kernel)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # of what is harmed
@pytest.mark.parametrize("fault", FAULTS, ids=str)
def test_a_fault_turns_its_check_red(fault, monkeypatch):
    assert without_fault(fault.seen) == "agree"
    prepare(monkeypatch, fault.seen)
    plant(monkeypatch, fault.place, fault.old, fault.new)
    assert CHECKS[fault.seen.check](fault.seen) == "differ"  # no fault merely raises
