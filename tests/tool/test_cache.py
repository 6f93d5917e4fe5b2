"""Compiled functions depend on every source beside them; all that is kept is cleared at once."""

import os
from pathlib import Path

import pytest

from crosscheck.models import numba_cache
from crosscheck.models.numba_cache import njit
from tests.tool.code import SOURCE, doubled


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    """The folder of a file with a function, compiled and kept."""
    (tmp_path / "doubling").mkdir()
    (tmp_path / "doubling" / "doubling.py").write_text(SOURCE)
    return tmp_path / "doubling"


@pytest.fixture
def kept(cache: Path, sources: Path) -> None:
    """A compiled function is kept."""
    assert doubled(sources) == (6.0, False)


def test_a_function_alone_may_be_handed_over():
    assert njit(lambda x: x + 1.0)(2.0) == 3.0


def test_a_change_of_any_source_beside_it_compiles_it_again(kept, sources):
    (sources / "called.py").write_text("FACTOR = 2.0")
    numba_cache._stamp.cache_clear()
    assert doubled(sources) == (6.0, False)


def test_a_folder_of_numbas_that_others_may_write_is_not_read(kept, sources, tmp_path, monkeypatch):
    monkeypatch.setattr(numba_cache.numba.config, "CACHE_DIR", str(tmp_path / "open"))
    assert doubled(sources) == (6.0, True)
    assert not (tmp_path / "open").exists()


def test_all_that_is_kept_is_cleared_and_its_sizes_reported(crosscheck, cache):
    sizes = {
        cache / f"{'a' * 32}.kept": 2_000_000,
        cache / "machine-code" / f"{'b' * 32}.o": 300_000,
        cache / "compiled" / "models_x" / "law.nbc": 100_000,
        cache / "compiled" / "models_y" / "law.nbi": 900_000,
    }
    letter = cache / "letter"
    for path, size in sizes.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
        os.truncate(path, size)
    letter.write_text("mine")
    answer = crosscheck("cache", "clear")
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.splitlines() == [
        f"removed 1 simulations, 2.0 MB, {cache}",
        f"removed 1 kernels, 0.3 MB, {cache / 'machine-code'}",
        f"removed 2 compiled functions, 1.0 MB, {cache / 'compiled'}",
    ]
    assert not any(path.exists() for path in sizes)
    assert letter.read_text() == "mine"
    assert crosscheck("cache", "clear").code == 0


def test_nothing_is_cleared_through_a_link(crosscheck, cache, tmp_path):
    (tmp_path / "theirs.o").touch()
    cache.mkdir(parents=True)
    (cache / "machine-code").symlink_to(tmp_path)
    answer = crosscheck("cache", "clear")
    assert (answer.code, answer.err) == (
        2,
        f"crosscheck: {cache / 'machine-code'}: is a link; remove it\n",
    )
    assert (tmp_path / "theirs.o").exists()
