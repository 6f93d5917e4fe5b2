"""Files that commands read, damaged at random: bytes, words and values; and what lies in place."""

import io
import random
import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import scipy.io
import xarray as xr

from tests.obstacles import OBSTACLES

Damage = Callable[[bytes, random.Random], bytes]
NUMBERS = (
    *("1e308", "-1e308", "1e155", "1e-308", "5e-324", "-5e-324", "1e400", "0", "-0.0", "1", "-1"),
    *("nan", "inf", "-inf", "1e9", "1e-9", "3", "2.5", "1_000", "1e5"),
    *("9" * 5000, "0x" + "f" * 6000),
)
VALUES_OF_TOML = (
    *("true", '"text"', '""', "[]", "[[]]", "{}", "{a = 1}", "1979-05-27", "07:32:00", "''", ""),
    *('"\\u0000"', '"a\\nb"', '"\\u001b[31mred"', '"[/opt/x.so]"', '"' + "long " * 99 + '"'),
    *("[1, 2.5]", "[1, [2]]", "[1e308]", "[nan, 1]", "[" * 2000, "{a = {b = " * 900, '"\\ud800"'),
)
KEYS = (
    *("table", "pd", "constant", "number", "list", "float", "tuple", "funding", "kind", "drive"),
    *("arm", "joints", "links", "name", "*", "0", "-1", "\u0663", '"a b"', '""', "a.b", "x" * 900),
)
LINES = ("[[joints]]", "[arm]", "[a.b.c]", "]", "x" * 1000, "[[links]]", "[start]", "[drive.table]")
ODD = (b"\xd9\xa3", b"\xff\xfe", b"\0", b"\x1b[31m", b"<a>" * 2000, b"[" * 2000, b"'", b'"', b"\r")
HUGE = (b"1" + b"0" * 400, b"-1e400", b"")
PIECES = (
    *(*HUGE, *ODD),
    *(text.encode("utf-8", "replace") for text in (*NUMBERS[:20], *VALUES_OF_TOML[:9], *KEYS)),
)
VALUES = (np.nan, np.inf, -np.inf, 1e300, -1e300, 1e-300, 0.0, 1e9, 2**63 * 1.0)
WORD = re.compile(rb"[\w.+-]+")


def flip_bits(content: bytes, generator: random.Random) -> bytes:
    """Some bits the other way."""
    changed = bytearray(content)
    for _ in range(generator.choice((1, 1, 8, 64))):
        if changed:
            changed[generator.randrange(len(changed))] ^= 1 << generator.randrange(8)
    return bytes(changed)


def truncate(content: bytes, generator: random.Random) -> bytes:
    """Nothing behind some place."""
    return content[: generator.choice((0, generator.randint(0, len(content))))]


def move_piece(content: bytes, generator: random.Random) -> bytes:
    """A piece left out, or twice, or zeros in its place."""
    one, other = sorted(generator.randint(0, len(content)) for _ in range(2))
    other = min(other, one + 4000)
    piece = generator.choice((b"", 2 * content[one:other], bytes(other - one)))
    return content[:one] + piece + content[other:]


def replace_word(content: bytes, generator: random.Random) -> bytes:
    """A word or number in place of another, of the same file or none."""
    words = list(WORD.finditer(content))
    if not words:
        return content
    one = generator.choice(words)
    new = generator.choice(PIECES) if generator.random() < 0.7 else generator.choice(words).group()
    return content[: one.start()] + new + content[one.end() :]


def replace_line(content: bytes, generator: random.Random) -> bytes:
    """A line left out, twice, or another one."""
    lines = content.split(b"\n")
    place = generator.randrange(len(lines))
    lines[place : place + 1] = generator.choice(
        ([], [lines[place]] * 2, [generator.choice(lines)], [generator.choice(PIECES)])
    )
    return b"\n".join(lines)


def _replace(pattern: str, new: Callable[[str, random.Random], str]) -> Damage:
    """An accident of UTF-8: one of the places of a pattern becomes something else."""

    def damage(content: bytes, generator: random.Random) -> bytes:
        text = content.decode("utf-8", "replace")
        if not (found := list(re.finditer(pattern, text, re.M))):
            return content
        one = generator.choice(found)
        text = text[: one.start()] + new(one.group(), generator) + text[one.end() :]
        return text.encode("utf-8", "surrogatepass")

    return damage


def _exchange(pattern: str) -> Damage:
    """What a pattern finds in one place, and so it stands in another."""

    def damage(content: bytes, generator: random.Random) -> bytes:
        found = re.findall(pattern, content.decode("utf-8", "replace"))
        return _replace(pattern, lambda _, generator: generator.choice(found))(content, generator)

    return damage


def _draw_value(_: str, generator: random.Random) -> str:
    return generator.choice(NUMBERS if generator.random() < 0.6 else VALUES_OF_TOML)


def _draw_line(old: str, generator: random.Random) -> str:
    line = f"{generator.choice(KEYS)} = {_draw_value(old, generator)}"
    return f"{old}\n{generator.choice((line, *LINES))}"


def _scale(number: str, generator: random.Random) -> str:
    return repr(float(number) * 2 ** generator.uniform(-1, 1))


TOML = (
    *3 * [_replace(r"(?<== )[^#\n]+", _draw_value)],
    *2 * [_replace(r"(?<== )[\d.e+-]+$", _scale)],
    _replace(r"^\w+(?= =)", lambda _, generator: generator.choice(KEYS)),
    _replace(r"^.*$", _draw_line),
)
ATTRIBUTE, CONTENT, ELEMENT = r"\b\w+(?==\")", r"(?<==\")[^\"]*", r"(?<=<)\w+(?=[^<>]*/>)"
XML = (*2 * [_replace(CONTENT, _draw_value)], *map(_exchange, (CONTENT, ATTRIBUTE, ELEMENT)))


def damage_archive(content: bytes, generator: random.Random) -> bytes:
    """A description that is damaged itself, and members that no archive should have."""
    packed = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(packed, "w") as new:
        for name in old.namelist():
            member = old.read(name)
            if name.endswith(".xml"):
                member = generator.choice((*XML, damage_text))(member, generator)
            if generator.random() < 0.9:
                new.writestr(name, member)
        if generator.random() < 0.3:
            odd = ("resources/a/b", "resources/a", "d/" * 99 + "x", "n" * 300, "../x", "binaries/")
            for name in generator.sample(odd, 2):
                new.writestr(name, b"x")
    return packed.getvalue()


def damage_variables(content: bytes, generator: random.Random) -> bytes:
    """A variable or attribute of a NetCDF file with other values, another shape, name or type."""
    data = xr.load_dataset(io.BytesIO(content), engine="h5netcdf")
    name = generator.choice(list(data.variables))
    values = np.array(data[name].values)
    kind = generator.choice(("value", "value", "values", "type", "drop", "name", "attribute"))
    if kind in ("value", "values") and values.size and values.dtype.kind in "fiu":
        values = values.astype(float)
        where = generator.randrange(values.size) if kind == "value" else slice(None)
        values.flat[where] = generator.choice(VALUES)
        data[name] = (data[name].dims, values, data[name].attrs)
    elif kind == "type":
        data[name] = (data[name].dims, values.astype(str), data[name].attrs)
    elif kind == "drop":
        data = data.drop_vars(name)
    elif kind == "name":
        data = data.rename({name: generator.choice(("theta", "t", "x" * 300, "\u0663"))})
    elif data.attrs:
        own = generator.choice(list(data.attrs))
        data.attrs[own] = generator.choice(("", "{}", "[]", "x" * 5000, 3.5, "\x1b[31m"))
    return bytes(data.to_netcdf(engine="h5netcdf"))


def damage_matrices(content: bytes, generator: random.Random) -> bytes:
    """A variable of a MAT file with other values, another shape or name."""
    data = {k: v for k, v in scipy.io.loadmat(io.BytesIO(content)).items() if k[0] != "_"}
    name = generator.choice(list(data))
    values = data[name].astype(float)
    values.flat[generator.randrange(values.size)] = generator.choice(VALUES)
    new = (values, values.T, values[None], values[:0], values.astype(str), {"a": 1}, values + 1j)
    data[generator.choice((name, name, "odd"))] = generator.choice(new)
    packed = io.BytesIO()
    scipy.io.savemat(packed, data)
    return packed.getvalue()


def damage_text(content: bytes, generator: random.Random) -> bytes:
    """An accident of any text."""
    text = (replace_word, replace_word, replace_word, replace_line, flip_bits, truncate, move_piece)
    return generator.choice(text)(content, generator)


def damage_bytes(content: bytes, generator: random.Random) -> bytes:
    """An accident of any file."""
    return generator.choice((flip_bits, flip_bits, truncate, move_piece))(content, generator)


DAMAGES: dict[str, tuple[Damage, ...]] = {
    ".toml": (*TOML, *3 * [damage_text]),
    ".xml": (*XML, *3 * [damage_text]),
    ".urdf": (*XML, *3 * [damage_text]),
    ".nc": (damage_variables, damage_variables, damage_bytes),
    ".mat": (damage_matrices, damage_matrices, damage_bytes),
    ".fmu": (damage_archive, damage_archive, damage_bytes),
}


def damaged(path: Path, generator: random.Random) -> bytes:
    """The content of a file after one to three accidents of its kind."""
    content = path.read_bytes()
    for _ in range(generator.choice((1, 1, 1, 2, 3))):
        damage = generator.choice(DAMAGES.get(path.suffix, (damage_text,)))
        try:
            content = damage(content, generator)
        except Exception:  # what an accident before it has left is no such file any more
            content = damage_bytes(content, generator)
    return content


def place_damaged(paths: list[Path], folder: Path, generator: random.Random) -> list[str]:
    """Put copies of files into a folder, one of them damaged or no file; returns what it is."""
    unlucky, what = generator.choice(paths), "damaged"
    for path in paths:
        target = folder / path.name
        if path != unlucky:
            target.write_bytes(path.read_bytes())
        elif generator.random() < 0.05:
            what = generator.choice([*OBSTACLES, "missing"])
            if what in OBSTACLES:
                OBSTACLES[what](target)
        else:
            target.write_bytes(damaged(path, generator))
    return [unlucky.name, what]
