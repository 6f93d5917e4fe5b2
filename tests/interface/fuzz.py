"""Bad input of every kind at random: command lines, and the files that they name."""

from __future__ import annotations

import random
import re
from pathlib import Path
from typing import NamedTuple

from models.loading import HERE

ARMS = [path.read_text(encoding="utf-8") for path in sorted((HERE / "arms").glob("*.toml"))]
SCENARIOS = [path.read_text(encoding="utf-8") for path in (HERE / "scenarios").glob("*.toml")]
DIGITS = "9" * 5000
NUMBERS = (
    *("1e308", "-1e308", "1e155", "1e-308", "5e-324", "-5e-324", "1e400", "0", "-0.0", "1", "-1"),
    *("nan", "inf", "-inf", "1e9", "1e-9", "3", "2.5", "0x" + "f" * 6000, DIGITS, "1_000", "1e5"),
)
OTHERS = (
    *("true", '"text"', '""', "[]", "[[]]", "{}", "{a = 1}", "1979-05-27", "07:32:00", "''", ""),
    *('"\\u0000"', '"a\\nb"', '"\\u001b[31mred"', '"[/opt/x.so]"', '"' + "long " * 99 + '"'),
    *("[1, 2.5]", "[1, [2]]", "[1e308]", "[nan, 1]", "[" * 2000, "{a = {b = " * 900, '"\\ud800"'),
)
KEYS = (
    *("table", "pd", "constant", "number", "list", "float", "tuple", "funding", "kind", "drive"),
    *("arm", "joints", "links", "name", "*", "0", "-1", "\u0663", '"a b"', '""', "a.b", "x" * 900),
)
CHARACTERS = "\x00\x1b\n\t \u202e\u0663\u00e9\U0001f600[]{}=.,#\"'\\0e-_"


class Draw(NamedTuple):
    """Arguments of the command line, and the files to write before it."""

    arguments: list[str]
    files: dict[Path, str]


def mangled(text: str, generator: random.Random) -> str:
    """A TOML text after one to three accidents."""
    accidents = (new_value, new_value, new_value, new_key, new_line, lost_line, doubled_line,
                 torn, scratched)  # fmt: skip
    for _ in range(generator.randint(1, 3)):
        text = generator.choice(accidents)(text, generator)
    return text


def new_value(text: str, generator: random.Random) -> str:
    """Another value behind a key."""
    return _changed(text, r"(?m)(?<== )[^#\n]+", _value(generator), generator)


def new_key(text: str, generator: random.Random) -> str:
    """Another key."""
    return _changed(text, r"(?m)^\w+(?= =)", generator.choice(KEYS), generator)


def new_line(text: str, generator: random.Random) -> str:
    """A line more, anywhere."""
    lines = text.split("\n")
    line = generator.choice((f"{generator.choice(KEYS)} = {_value(generator)}", "[[joints]]",
                             "[arm]", "[a.b.c]", "]", "x" * 1000, ".".join("a" * 3000) + " = 1",
                             "[[links]]", "[start]", "[drive.table]"))  # fmt: skip
    lines.insert(generator.randint(0, len(lines)), line)
    return "\n".join(lines)


def lost_line(text: str, generator: random.Random) -> str:
    """A line less."""
    lines = text.split("\n")
    del lines[generator.randrange(len(lines))]
    return "\n".join(lines)


def doubled_line(text: str, generator: random.Random) -> str:
    """A line twice, the second time anywhere."""
    lines = text.split("\n")
    lines.insert(generator.randint(0, len(lines)), generator.choice(lines))
    return "\n".join(lines)


def torn(text: str, generator: random.Random) -> str:
    """Nothing behind some place."""
    return text[: generator.randint(0, len(text))]


def scratched(text: str, generator: random.Random) -> str:
    """Some characters replaced by others."""
    for _ in range(generator.randint(1, 5)):
        at = generator.randint(0, len(text))
        text = text[:at] + generator.choice(CHARACTERS) + text[at + 1 :]
    return text


def _changed(text: str, pattern: str, new: str, generator: random.Random) -> str:
    found = list(re.finditer(pattern, text))
    if not found:
        return text
    one = generator.choice(found)
    return text[: one.start()] + new + text[one.end() :]


def _value(generator: random.Random) -> str:
    return generator.choice(NUMBERS if generator.random() < 0.6 else OTHERS)


def setting(generator: random.Random) -> str:
    """A ``path=value``, right or wrong in either part."""
    section = generator.choice(("arm", "scenario", "switches", "arm", "robot", ""))
    fields = re.findall(r"(?m)^\w+(?= =)", "\n".join(ARMS + SCENARIOS))
    levels = ("joints", "links", "drive", "start", *KEYS), ("0", "1", "2", *KEYS), fields
    parts = [section, *(generator.choice(some) for some in levels if generator.random() < 0.7)]
    equals = "" if generator.random() < 0.05 else "="
    return f"{'.'.join(parts)}{equals}{_value(generator)}".replace("\x00", "")


def draw(command: str, folder: Path, generator: random.Random) -> Draw:
    """A command line of this command, and files in the folder that it reads."""
    files = {}
    arm = generator.choice(("paper-labelled", "probe", "nobody", "", "/dev/null", str(folder)))
    if generator.random() < 0.8:
        arm = str(folder / "arm.toml")
        files[folder / "arm.toml"] = mangled(generator.choice(ARMS), generator)
    arguments = [*command.split(), arm, *_options(command, folder, generator)]
    if command == "simulate" and generator.random() < 0.5:
        file = folder / "scenario.toml"
        files[file] = mangled(generator.choice(SCENARIOS), generator)
        arguments += ["--scenario", str(file)]
    return Draw([argument.replace("\x00", "") for argument in arguments], files)


def _options(command: str, folder: Path, generator: random.Random) -> list[str]:
    """Some of the command's options, with values right and wrong."""
    number = generator.choice((*NUMBERS[:-8], "0.01", "1e-6", "words", "", "\u0663"))
    count = generator.choice(("1", "2", "0", "-1", "1e3", "99999999999999999999", "\u0663", "x"))
    file = str(folder / generator.choice(("out/a.json", "arm.toml/a", "", ".", "a.json")))
    records = ["--dir", str(folder / generator.choice(("records", "arm.toml", "")))]
    known: dict[str, tuple[list[str], ...]] = {
        "run": (["--quick"], ["--jobs", count], ["--seed", count], ["--out", file]),
        "validate": (["--quick"], ["--jobs", count], ["--seed", count], ["--json", file]),
        "baseline accept": (["--quick"], ["--jobs", count], records, ["--junit", file]),
        "baseline check": (["--quick"], ["--jobs", count], records, ["--junit", file]),
        "errata": (["--json", file],),
        "show": ((["--fast"],) if generator.random() < 0.05 else ()),
        "simulate": (
            ["--t-end", number],
            ["--step", number],
            ["--phase", generator.choice(("angle", "omega_t", "beta"))],
            ["--set", setting(generator)],
            ["--set", setting(generator)],
            ["--force"],
        ),
    }
    chosen = [part for option in known[command] if generator.random() < 0.3 for part in option]
    if command == "simulate":
        models = (
            "analytic:physical",
            "analytic:coupled",
            "exudyn:tree",
            "nobody",
            "pinocchio:links",
        )
        scenarios = ("pd", "constant-torque", "back-and-forth", "waltz", "")
        chosen += ["--model", generator.choice(models), "--scenario", generator.choice(scenarios)]
        chosen += ["--out", file or "a.nc"]
    return chosen
