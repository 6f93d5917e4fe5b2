"""The file of an FMU, a ZIP archive: looked at as a whole before anything of it is unpacked."""

from __future__ import annotations

import io
import platform
import stat
import zipfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from crosscheck.models.errors import InputError
from crosscheck.models.inputs import input_content

LARGEST_FILE = 200_000_000  # bytes
MOST_BYTES, MOST_FILES = 500_000_000, 10_000  # unpacked
LARGEST_RATIO = 200  # of what is packed well; a bomb has a thousand and more
DESCRIPTION = "modelDescription.xml"
LARGEST_DESCRIPTION = 50_000_000
BINARIES = {
    ("Linux", "x86_64"): ("linux64", "x86_64-linux"),
    ("Linux", "aarch64"): ("aarch64-linux",),
    ("Darwin", "arm64"): ("aarch64-darwin", "darwin64"),
}


def unpacked(path: Path, folder: Path) -> None:
    """Unpack description, resources and this machine's binaries into an empty folder.

    Raises InputError for what is no FMU, leads out of the folder or grows beyond all measure;
    nothing is unpacked then.
    """
    where = str(path)
    content = input_content(path, LARGEST_FILE)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            entries = archive.infolist()
            _require_harmless(where, entries)
            for entry, name in _wanted(where, entries):
                target = folder / name
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(archive.read(entry))
    except (zipfile.BadZipFile, NotImplementedError, EOFError, RuntimeError) as error:
        raise InputError(where, "", None, f"is no FMU: {error}") from None
    description = (folder / DESCRIPTION).read_bytes()
    if b"<!DOCTYPE" in description or b"<!ENTITY" in description or b"\0" in description:
        reason = "must be XML in UTF-8 without definitions of its own"
        raise InputError(where, DESCRIPTION, None, reason)


def library_of(where: str, folder: Path, identifier: str) -> Path:
    """This machine's binary of an unpacked unit. Raises InputError where there is none."""
    for name in _folders():
        for suffix in (".so", ".dylib"):
            found = folder / "binaries" / name / f"{identifier}{suffix}"
            if found.is_file():
                return found
    machine = f"{platform.system()} {platform.machine()}"
    raise InputError(where, "binaries", None, f"holds none of {identifier} for {machine}")


def _folders() -> tuple[str, ...]:
    return BINARIES.get((platform.system(), platform.machine()), ())


def _require_harmless(where: str, entries: list[zipfile.ZipInfo]) -> None:
    """Raise InputError for an archive that no program should unpack."""
    if len(entries) > MOST_FILES:
        raise InputError(where, "", None, f"holds {len(entries)} files; may hold {MOST_FILES}")
    size = sum(entry.file_size for entry in entries)
    if size > MOST_BYTES:
        raise InputError(where, "", None, f"would unpack to {size} bytes; may have {MOST_BYTES}")
    seen: set[str] = set()
    for entry in entries:
        name = entry.filename
        path = PurePosixPath(name)
        if path.is_absolute() or ".." in path.parts or set("\\:\0") & set(name) or not name:
            raise InputError(where, name, None, "leads out of the folder that it is unpacked into")
        if stat.S_ISLNK(entry.external_attr >> 16):
            raise InputError(where, name, None, "is a link; must be a file")
        if entry.flag_bits & 1:
            raise InputError(where, name, None, "is encrypted")
        if entry.file_size > LARGEST_RATIO * max(entry.compress_size, 1000):
            reason = f"is packed {entry.file_size // max(entry.compress_size, 1)} times; may be"
            raise InputError(where, name, None, f"{reason} {LARGEST_RATIO} times")
        if str(path) in seen:
            raise InputError(where, name, None, "is there twice")
        seen.add(str(path))


def _wanted(where: str, entries: list[zipfile.ZipInfo]) -> Iterator[tuple[zipfile.ZipInfo, str]]:
    """What is unpacked. Raises InputError without a description."""
    folders = [f"binaries/{name}/" for name in _folders()]
    found = {entry.filename: entry for entry in entries if not entry.is_dir()}
    if DESCRIPTION not in found:
        raise InputError(where, DESCRIPTION, None, "is missing: this is no FMU")
    if found[DESCRIPTION].file_size > LARGEST_DESCRIPTION:
        raise InputError(where, DESCRIPTION, None, f"has more than {LARGEST_DESCRIPTION} bytes")
    for name, entry in found.items():
        if name == DESCRIPTION or name.startswith(("resources/", *folders)):
            yield entry, name
