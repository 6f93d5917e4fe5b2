"""Bad input of every kind at random: command lines, and the files that they name."""

import io
import random
import re
import zipfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from crosscheck.analytic.kernel.fmu import generate_unit
from crosscheck.models.files import HERE
from crosscheck.trial.fmu.archive import DESCRIPTION

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
    files: dict[Path, str | bytes]


def mangled(text: str, generator: random.Random) -> str:
    """A TOML text, or XML of an element a line, after up to two accidents."""
    accidents = XML_ACCIDENTS if text.startswith("<") else TOML_ACCIDENTS
    for _ in range(generator.choice((0, 1, 1, 2))):
        text = generator.choice(accidents)(text, generator)
    return text


def scaled(text: str, generator: random.Random) -> str:
    """A number up to twice as large, or half."""
    factor = 2 ** generator.uniform(-1, 1)
    return _changed(
        text, r"(?m)(?<== )[\d.e+-]+$", lambda old: repr(float(old) * factor), generator
    )


def new_value(text: str, generator: random.Random, pattern: str = r"(?m)(?<== )[^#\n]+") -> str:
    """Another value behind a key."""
    return _changed(text, pattern, lambda _: _value(generator), generator)


def exchanged(text: str, generator: random.Random, pattern: str) -> str:
    """What a pattern finds in one place, and so it stands in another."""
    found = re.findall(pattern, text)
    return _changed(text, pattern, lambda _: generator.choice(found), generator)


def new_key(text: str, generator: random.Random) -> str:
    """Another key."""
    return _changed(text, r"(?m)^\w+(?= =)", lambda _: generator.choice(KEYS), generator)


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


TOML_ACCIDENTS = (new_value, new_value, new_value, scaled, scaled, new_key, new_line, lost_line,
                  doubled_line, torn, scratched)  # fmt: skip
ATTRIBUTE, CONTENT, ELEMENT = r"\b\w+(?==\")", r"(?<==\")[^\"]*", r"(?<=<)\w+(?=[^<>]*/>)"
XML_ACCIDENTS = (
    *(2 * (partial(new_value, pattern=CONTENT),)),
    *(partial(exchanged, pattern=part) for part in (CONTENT, CONTENT, ATTRIBUTE, ELEMENT)),
    *(lost_line, doubled_line, torn, scratched),
)


def _changed(text: str, pattern: str, new: Callable[[str], str], generator: random.Random) -> str:
    found = list(re.finditer(pattern, text))
    if not found:
        return text
    one = generator.choice(found)
    return text[: one.start()] + new(one.group()) + text[one.end() :]


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


def mostly(right: Sequence[str], wrong: Sequence[str], generator: random.Random) -> str:
    """One of the right ones, or now and then a wrong one."""
    return generator.choice(right if generator.random() < 0.85 else wrong)


STUDY = Path(__file__).with_name("study.toml").read_text(encoding="utf-8")


def study_draw(folder: Path, generator: random.Random) -> Draw:
    """`sweep`, with what an earlier run, or somebody else, has left where its result goes."""
    study = mangled(STUDY, generator)
    words = re.findall(r'"[^"\n]+"', STUDY)
    for _ in range(generator.choice((0, 0, 0, 1, 2))):
        study = study.replace(generator.choice(words), generator.choice((*words, '"*"', '"joint"')))
    files = {
        folder / "study.toml": study,
        folder / "arm.toml": generator.choice(ARMS),
        folder / "scenario.toml": generator.choice(SCENARIOS),
        folder / "mine.py": mangled(
            "def f(run):\n    return {'last': run.theta[-1, 0]}\n", generator
        ),
    }
    left = generator.choice(("nothing", "nothing", "result", "mark", "batches", "in the way"))
    content = generator.choice(
        ("", "\0" * 100, "mine\n", "f" * 64 + "\n" + "0" * 32 + "\n" + DIGITS)
    )
    path = {
        "result": folder / "a.nc",
        "mark": folder / "a.nc.batches" / "study",
        "batches": folder / "a.nc.batches" / f"{'0' * 32}.kept",
        "in the way": folder / "a.nc.batches",
    }.get(left)
    files |= {path: content} if path else {}
    out = mostly(("a.nc", "out/a.nc"), ("", "arm.toml/a.nc", "x" * 255, "study.toml"), generator)
    named = mostly(
        ("study.toml",), ("arm.toml", "nowhere", "", "mine.py", "a.nc.batches"), generator
    )
    some = [["--resume"], ["--jobs", generator.choice(("1", "2", "0", "x"))]]
    chosen = [["--out", str(folder / out)], *([["--run-code"]] if generator.random() < 0.9 else [])]
    chosen += [option for option in some if generator.random() < 0.3]
    arguments = ["sweep", str(folder / named), *(part for option in chosen for part in option)]
    return Draw([argument.replace("\x00", "") for argument in arguments], files)


def init_draw(folder: Path, generator: random.Random) -> Draw:
    """`init`, for files of any name, some of which exist."""
    letters = [generator.choice(CHARACTERS) for _ in range(generator.choice((0, 1, 9, 300)))]
    name = "".join(letters).replace("\x00", "").replace("/", "") or "study.toml"
    count = mostly(("1", "7"), ("0", "8", "x", ""), generator)
    return Draw(["init", str(folder / name), "--joints", count], {folder / "study.toml": "mine"})


MJCF = Path(__file__).with_name("robot.xml").read_text(encoding="utf-8")
ROBOT = """schema_version = 1
name = "robot"
urdf = "robot.xml"
gravity_m_per_s2 = [0.0, 0.0, -9.81]
tip = "left"
friction = "from-urdf"

[joints.shoulder]
kind = "geared"
ratio = 50.0
rotor_inertia_kg_m2 = 1e-4
stator = "base"
rotor_axis = [0.0, 1.0, 0.0]

[joints.elbow]
kind = "direct"
friction_N_m_s_per_rad = 0.5

[links.lower]
mass_kg = 2.0
"""


def robot_draw(folder: Path, generator: random.Random) -> Draw:
    """`show` of MuJoCo's format, by itself or named by a robot's file."""
    files = {folder / "robot.xml": mangled(MJCF, generator), folder / "robot.toml": ROBOT}
    name = generator.choice(("robot.xml", "robot.xml", "robot.toml"))
    if name == "robot.toml":
        files[folder / name] = mangled(ROBOT, generator)
    return Draw(["show", str(folder / name)], files)


UNIT = generate_unit("", "unit", [("a", "rad"), ("b", "m")], ["N.m", "N"])[1]


def unit_draw(folder: Path, generator: random.Random) -> Draw:
    """`trial --ask` of an FMU, of which the description or the archive is damaged."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", generator.choice((0, 8))) as archive:
        archive.writestr(DESCRIPTION, mangled(UNIT, generator))
        archive.writestr("binaries/linux64/unit.so", b"\x7fELF")
    packed = content.getvalue()
    if generator.random() < 0.3:
        text = generator.choice((torn, scratched))(packed.decode("latin-1"), generator)
        packed = text.encode("latin-1", "replace")
    arguments = ["trial", str(folder / "unit.fmu"), "--ask", "--out", str(folder / "new")]
    return Draw(arguments, {folder / "unit.fmu": packed})


DRAWS_OF = {"sweep": study_draw, "init": init_draw, "show MJCF": robot_draw, "trial FMU": unit_draw}


def draw(command: str, folder: Path, generator: random.Random) -> Draw:
    """A command line of this command, and files in the folder that it reads."""
    if command in DRAWS_OF:
        return DRAWS_OF[command](folder, generator)
    files = {folder / "arm.toml": mangled(generator.choice(ARMS), generator)}
    wrong = ("paper-labelled", "nobody", "", "/dev/null", "/dev/zero", str(folder))
    arm = mostly([str(folder / "arm.toml")], wrong, generator)
    options = _simulate if command == "simulate" else _options(command)
    chosen = options(folder, generator)
    if "scenario.toml" in str(chosen):
        files[folder / "scenario.toml"] = mangled(generator.choice(SCENARIOS), generator)
    arguments = [*command.split(), arm, *(part for option in chosen for part in option)]
    return Draw([argument.replace("\x00", "") for argument in arguments], files)


def _options(command: str) -> Callable[[Path, random.Random], list[list[str]]]:
    """What draws some of a command's options, with values right and wrong."""

    def drawn(folder: Path, generator: random.Random) -> list[list[str]]:
        count = mostly(("1", "2"), ("0", "-1", "1e3", "9" * 20, "\u0663", "x", ""), generator)
        file = mostly(("out/a.json", "a.json"), ("arm.toml/a", "", ".", "a/../.."), generator)
        known = {
            "--quick": [],
            "--jobs": [count],
            "--seed": [count],
            "--out": [str(folder / file)],
            "--json": [str(folder / file)],
            "--junit": [str(folder / file)],
            "--dir": [str(folder / mostly(("records",), ("arm.toml", ""), generator))],
            "--fast": [],
        }
        usual = KNOWN[command] if generator.random() < 0.95 else tuple(known)
        return [[name, *known[name]] for name in usual if generator.random() < 0.3]

    return drawn


KNOWN = {
    "run": ("--quick", "--jobs", "--seed", "--out"),
    "validate": ("--quick", "--jobs", "--seed", "--json", "--junit"),
    "baseline accept": ("--quick", "--jobs", "--dir", "--junit"),
    "baseline check": ("--quick", "--jobs", "--dir", "--junit"),
    "errata": ("--json", "--out"),
    "show": (),
}


def _simulate(folder: Path, generator: random.Random) -> list[list[str]]:
    """Options of `simulate`."""
    models = ("analytic:physical", "analytic:coupled", "exudyn:tree", "pinocchio:links")
    scenarios = ("pd", "constant-torque", "back-and-forth", str(folder / "scenario.toml"))
    number = mostly(("0.01", "1e-5", "5e-6", "2"), (*NUMBERS[:-8], "words", "\u0663"), generator)
    some = [
        ["--t-end", number],
        ["--step", number],
        ["--set", setting(generator)],
        ["--set", setting(generator)],
        ["--force"],
    ]
    return [
        ["--model", mostly(models, ("nobody", "pinocchio:gears", ""), generator)],
        ["--scenario", mostly(scenarios, ("waltz", ""), generator)],
        ["--out", str(folder / mostly(("a.nc", "out/a.nc"), ("", "arm.toml/a.nc"), generator))],
        *(option for option in some if generator.random() < 0.25),
    ]
