"""What is kept between runs: made again where it is damaged, and cleared by one command."""

import os
from pathlib import Path

import pytest

from crosscheck.models import numba_cache
from crosscheck.models.directories import prepare_code_folder
from crosscheck.models.numba_cache import njit
from tests.processes import NOBODY, in_child, reachable

SOURCE = """
from crosscheck.models.numba_cache import njit

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
def sources(tmp_path: Path) -> Path:
    """The folder of a file with a function."""
    (tmp_path / "doubling").mkdir()
    (tmp_path / "doubling" / "doubling.py").write_text(SOURCE)
    return tmp_path / "doubling"


@pytest.fixture
def kept(cache: Path, sources: Path) -> Path:
    """The folder of a compiled function's files."""
    assert doubled(sources) == (6.0, False)
    assert doubled(sources) == (6.0, True)
    (folder,) = (cache / "compiled").iterdir()
    return folder


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("damage", ["empty", "half", "flipped", "pickle", "folder"])
def test_a_damaged_function_is_compiled_again_with_one_line(kept, sources, suffix, damage, capsys):
    (path,) = kept.glob(f"*.{suffix}")
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
    assert doubled(sources) == (6.0, False)
    said = capsys.readouterr().err.splitlines()
    assert said
    assert all(line.startswith("crosscheck: ") and "it is made again" in line for line in said)
    if damage != "folder":
        assert len(set(said)) == 1
        assert doubled(sources) == (6.0, True)


def test_a_function_of_another_version_of_numba_is_compiled_again(
    kept, sources, monkeypatch, capsys
):
    monkeypatch.setattr(numba_cache.numba, "__version__", "999")
    assert doubled(sources) == (6.0, False)
    assert capsys.readouterr().err == ""


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


def another_users(path: Path) -> None:
    os.chown(path, NOBODY, NOBODY)


def link(path: Path) -> None:
    target = path.with_name("elsewhere")
    path.rename(target)
    path.symlink_to(target)


NOT_PRIVATE = {
    "another user's": (another_users, "belongs to another user"),
    "writable": (lambda path: path.chmod(0o666), "may be written by others"),
    "a link": (link, "is a link"),
}


@pytest.mark.parametrize("case", NOT_PRIVATE)
@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_a_kept_pickle_that_is_not_the_users_own_is_not_run(kept, sources, suffix, case, capsys):
    spoil, said = NOT_PRIVATE[case]
    if spoil is another_users and os.geteuid() != 0:
        pytest.skip("only root can give files away")
    (path,) = kept.glob(f"*.{suffix}")
    spoil(path)
    assert doubled(sources) == (6.0, False)
    assert f"{path.name}: does not fit: {said}; it is made again" in capsys.readouterr().err
    assert doubled(sources) == (6.0, True)
    assert capsys.readouterr().err == ""


def test_what_lies_in_a_folder_that_others_could_write_is_removed(kept, sources, cache):
    (cache / "compiled").chmod(0o777)
    prepare_code_folder.cache_clear()
    assert doubled(sources) == (6.0, False)
    assert (cache / "compiled").stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("place", [".", "compiled"])
def test_a_folder_is_not_changed_through_a_link(sources, cache, place, tmp_path, capsys):
    theirs = tmp_path / "theirs"
    theirs.mkdir(mode=0o755)
    (cache / place).parent.mkdir(parents=True)
    (cache / place).symlink_to(theirs)
    assert doubled(sources) == (6.0, False)
    assert theirs.stat().st_mode & 0o777 == 0o755
    assert list(theirs.iterdir()) == []
    line = f"crosscheck: {cache / place}: is a link; nothing is kept\n"
    assert capsys.readouterr().err == line


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can be somebody else")
def test_a_folder_of_another_user_is_not_used(sources, cache, tmp_path):
    cache.mkdir(parents=True)
    cache.chmod(0o777)
    reachable(sources)
    reachable(cache)

    def compile_as_nobody() -> None:
        assert doubled(sources) == (6.0, False)

    assert in_child(compile_as_nobody, nobody=True)
    assert list(cache.iterdir()) == []


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
