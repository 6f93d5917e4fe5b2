"""What is kept between runs: made again where it is damaged, and cleared by one command."""

import os
from pathlib import Path

import pytest

from crosscheck.models import jitted
from crosscheck.models.jitted import njit
from crosscheck.models.places import own_folder
from crosscheck.runner import cache

SOURCE = """
from crosscheck.models.jitted import njit

@njit(cache=True)
def doubled(x):
    return 2.0 * x
"""


def doubled(folder: Path) -> tuple[float, bool]:
    """Of 3.0, by a function of a file there; and whether it was found compiled."""
    found: dict[str, object] = {"__name__": "doubling"}
    exec(compile(SOURCE, str(folder / "doubling.py"), "exec"), found)
    function = found["doubled"]
    value = function(3.0)  # type: ignore[operator]
    return value, bool(function.stats.cache_hits)  # type: ignore[attr-defined]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Of a file with a function that has been compiled."""
    (tmp_path / "doubling.py").write_text(SOURCE)
    assert doubled(tmp_path) == (6.0, False)
    assert doubled(tmp_path) == (6.0, True)
    return tmp_path / "__pycache__"


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("damage", ["empty", "half", "flipped", "pickle", "folder"])
def test_a_damaged_function_is_compiled_again_with_one_line(folder, suffix, damage, capsys):
    (path,) = folder.glob(f"*.{suffix}")
    sound = path.read_bytes()
    place = len(sound) // 2
    harmed = {
        "empty": b"",
        "half": sound[:place],
        "flipped": sound[:place] + bytes([sound[place] ^ 1]) + sound[place + 1 :],
        "pickle": b"cos\nsystem\n(S'exit 7'\ntR.",
    }
    path.unlink()
    if damage == "folder":
        path.mkdir()
    else:
        path.write_bytes(harmed[damage])
    assert doubled(folder.parent) == (6.0, False)
    said = capsys.readouterr().err.splitlines()
    assert said
    assert all(line.startswith("crosscheck: ") and "it is made again" in line for line in said)
    if damage != "folder":
        assert len(set(said)) == 1
        assert doubled(folder.parent) == (6.0, True)


def test_a_function_of_another_version_of_numba_is_compiled_again(folder, monkeypatch, capsys):
    monkeypatch.setattr(jitted.numba, "__version__", "999")
    assert doubled(folder.parent) == (6.0, False)
    assert capsys.readouterr().err == ""


def test_a_function_alone_may_be_handed_over():
    assert njit(lambda x: x + 1.0)(2.0) == 3.0


def test_all_that_is_kept_is_cleared_and_its_sizes_told(crosscheck, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(cache, "ROOT", tmp_path / "program")
    own_folder.cache_clear()
    own, models = tmp_path / "geararm-crosscheck", tmp_path / "program" / "crosscheck" / "models"
    sizes = {
        own / f"{'a' * 32}.kept": 2_000_000,
        own / "machine-code" / f"{'b' * 32}.o": 300_000,
        own / "compiled" / "models_x" / "law.nbc": 100_000,
        models / "__pycache__" / "law.nbi": 900_000,
    }
    letter = own / "letter"
    models.mkdir(parents=True)
    (models / "law.py").touch()
    for path, size in sizes.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
        os.truncate(path, size)
    letter.write_text("mine")
    answer = crosscheck("cache", "clear")
    own_folder.cache_clear()
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.splitlines() == [
        f"removed 1 simulations, 2.0 MB, {own}",
        f"removed 1 kernels, 0.3 MB, {own / 'machine-code'}",
        f"removed 2 compiled functions, 1.0 MB, {tmp_path / 'program'}",
    ]
    assert not any(path.exists() for path in sizes)
    assert letter.read_text() == "mine"
    assert crosscheck("cache", "clear").code == 0
