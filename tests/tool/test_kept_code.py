"""Compiled code that is kept between runs: found again, or made again with one line that says so.

Both sorts, functions of numba and objects of the kernel, are kept and believed by the same rules.
All that is kept is cleared at once.
"""

import os
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from crosscheck.analytic.kernel import machine
from crosscheck.models import numba_cache
from crosscheck.models.directories import prepare_code_folder
from crosscheck.models.numba_cache import njit
from tests.obstacles import obstruct
from tests.processes import NOBODY, in_child, reachable
from tests.tool.code import SOURCE, add, doubled


class Keeper(NamedTuple):
    """A sort of code: ``make()`` uses it and says whether it was found; the folder of its files."""

    make: Callable[[], bool]
    folder: Path

    def list_files(self) -> list[Path]:
        """The files of the one piece of code that is kept."""
        return sorted(
            path for path in self.folder.rglob("*") if path.suffix in (".nbc", ".nbi", ".o")
        )


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    """The folder of a file with a function for numba."""
    (tmp_path / "doubling").mkdir()
    (tmp_path / "doubling" / "doubling.py").write_text(SOURCE)
    return tmp_path / "doubling"


@pytest.fixture(params=["compiled", "machine-code"])
def keeper(
    request: pytest.FixtureRequest, cache: Path, sources: Path, monkeypatch: pytest.MonkeyPatch
) -> Keeper:
    """With one piece of code that is kept."""
    made, compile_ir = list[object](), machine.compile_ir
    monkeypatch.setattr(
        machine, "compile_ir", lambda *given: made.append(given) or compile_ir(*given)
    )

    def make_function() -> bool:
        value, is_found = doubled(sources)
        assert value == 6.0
        return is_found

    def make_object() -> bool:
        before = len(made)
        assert add() == 5.0
        return len(made) == before

    make = make_function if request.param == "compiled" else make_object
    assert [make(), make()] == [False, True]
    return Keeper(make, cache / request.param)


def spoil(change: Callable[[bytes], bytes]) -> Callable[[Path], object]:
    """A file with other bytes in the place of its own."""
    return lambda path: path.write_bytes(change(path.read_bytes()))


def link(path: Path) -> None:
    target = path.with_name("elsewhere")
    path.rename(target)
    path.symlink_to(target)


SPOILT: dict[str, tuple[Callable[[Path], object], str]] = {
    "empty": (spoil(lambda sound: b""), "damaged"),
    "half": (spoil(lambda sound: sound[: len(sound) // 2]), "damaged"),
    "flipped": (spoil(lambda sound: sound[:-9] + bytes([sound[-9] ^ 1]) + sound[-8:]), "damaged"),
    "longer": (spoil(lambda sound: sound + b"\0"), "damaged"),
    "pickle": (spoil(lambda sound: b"cos\nsystem\n(S'exit 7'\ntR."), "damaged"),
    "another": (spoil(lambda sound: b"\x7fELF of something else"), "damaged"),
    "a pipe": (obstruct("pipe"), "is not a regular file"),
    "a folder": (obstruct("folder"), "is not a regular file"),
    "a loop": (obstruct("loop"), "is a link"),
    "a link": (link, "is a link"),
    "writable": (lambda path: path.chmod(0o666), "may be written by others"),
    "another user's": (lambda path: os.chown(path, NOBODY, NOBODY), "belongs to another user"),
}


@pytest.mark.parametrize("case", SPOILT)
def test_what_is_not_the_users_own_sound_file_is_made_again_and_not_run(keeper, case, capsys):
    change, said = SPOILT[case]
    if case == "another user's" and os.geteuid() != 0:
        pytest.skip("only root can give files away")
    files = keeper.list_files()
    assert files
    for path in files:
        change(path)
        assert not keeper.make()
        lines = set(capsys.readouterr().err.splitlines())
        assert lines == {f"crosscheck: {path}: does not fit: {said}; it is made again"}
        if path.is_dir():
            path.rmdir()
            keeper.make()
        assert keeper.make()
        assert capsys.readouterr().err == ""


def test_what_lies_in_a_folder_that_others_could_write_is_removed(keeper):
    keeper.folder.chmod(0o777)
    prepare_code_folder.cache_clear()
    assert not keeper.make()
    assert keeper.folder.stat().st_mode & 0o777 == 0o700


OTHERS = (
    (numba_cache.numba, "__version__", "999"),
    (machine, "_processor", lambda: ("x86-64", "")),
    (machine, "_translator", lambda: ("another", "code")),
    (machine.llvmlite, "__version__", "999"),
)


def test_code_of_another_processor_compiler_or_translator_is_not_used(keeper, monkeypatch, capsys):
    own = OTHERS[:1] if keeper.folder.name == "compiled" else OTHERS[1:]
    for owner, name, other in own:
        with monkeypatch.context() as patch:
            patch.setattr(owner, name, other)
            assert not keeper.make()
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("place", [".", "compiled"])
def test_a_folder_is_not_changed_through_a_link(cache, place, tmp_path, capsys):
    theirs = tmp_path / "theirs"
    theirs.mkdir(mode=0o755)
    (cache / place).parent.mkdir(parents=True)
    (cache / place).symlink_to(theirs)
    prepare_code_folder("compiled")
    assert theirs.stat().st_mode & 0o777 == 0o755
    assert list(theirs.iterdir()) == []
    assert capsys.readouterr().err == f"crosscheck: {cache / place}: is a link; nothing is kept\n"


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can be somebody else")
def test_a_folder_of_another_user_is_not_used(cache):
    cache.mkdir(parents=True)
    cache.chmod(0o777)
    reachable(cache)
    assert in_child(lambda: prepare_code_folder("compiled"), nobody=True)
    assert list(cache.iterdir()) == []


def test_a_function_alone_may_be_handed_over():
    assert njit(lambda x: x + 1.0)(2.0) == 3.0


def test_a_change_of_any_source_beside_it_compiles_it_again(cache, sources):
    assert doubled(sources) == (6.0, False)
    (sources / "called.py").write_text("FACTOR = 2.0")
    numba_cache._stamp.cache_clear()
    assert doubled(sources) == (6.0, False)


def test_a_folder_of_numbas_that_others_may_write_is_not_read(
    cache, sources, tmp_path, monkeypatch
):
    assert doubled(sources) == (6.0, False)
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
