"""What a trial makes of equations with planted mistakes, and of right ones: one table.

Run as ``python -m benchmarks.bench_trial [WORD] [--all]`` from the project's folder: a sample of
each set in two minutes, or with --all every row; only those whose name has the word, with each that
is not named. The sets: mistakes of arms (tests/trial/mistakes), slips of robots (robot_slips.toml),
wrong edits of natural code (source_edits) and right models of random arms in random coordinates.
"""

from __future__ import annotations

import re
import sys
import tempfile
import time
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Robot
from crosscheck.planning.sizing import make_unequal_gains_scenario
from crosscheck.testing import try_equations
from crosscheck.trial.coordinates.build import LAYOUTS
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.input.loading import build_robot_equations
from crosscheck.trial.result import Trial
from tests.arms import random_arm
from tests.robots import chains, test_trial_motors, two_link
from tests.robots.trials import run_robot_trial
from tests.trial.mistakes.score import MISTAKES, Mistake, scored
from tests.trial.test_trial import equations_of, in_frame

TWO_LINK = """
m1, m2, L, c1, c2 = 5.0, 3.0, 1.0, 0.5, 0.3
J1, J2, rotor, n, g = 0.4, 0.2, 0.02, 10.0, 9.8

def mass_matrix(q):
    k = m2 * L * c2 * np.cos(q[1])
    M22 = J2 + m2 * c2**2
    M12 = J2 + m2 * c2**2 + k
    M21 = J2 + m2 * c2**2 + k
    M11 = J1 + m1 * c1**2 + J2 + m2 * (L**2 + c2**2) + 2 * k
    return np.array([[M11 + n**2 * rotor, M12], [M21, M22 + n**2 * rotor]])

def bias(q, v):
    h = m2 * L * c2 * np.sin(q[1])
    return np.array([-2 * h * v[0] * v[1] - h * v[1] ** 2, h * v[0] ** 2])

def gravity(q):
    g2 = m2 * c2 * g * np.cos(q[0] + q[1])
    g1 = (m1 * c1 + m2 * L) * g * np.cos(q[0]) + g2
    return np.array([g1, g2])
"""
CART_POLE = """
M, m, l, g = 1.4, 0.3, 0.7, 9.81
drive = [1]

def acceleration(q, v, u):
    s, c = np.sin(q[1]), np.cos(q[1])
    slide = (u + m * s * (l * v[1] ** 2 + g * c)) / (M + m * s**2)
    swing = -(u * c + m * l * v[1] ** 2 * c * s + (M + m) * g * s) / (l * (M + m * s**2))
    return np.array([slide, swing])
"""
SPATIAL = """
down = robot.gravity

def turned(axis, angle):
    K = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K

def frames(q):
    R, p, found = np.eye(3), np.zeros(3), []
    for k, (joint, angle) in enumerate(zip(robot.joints, q, strict=True)):
        p = p + R @ joint.placement.position
        R = R @ joint.placement.rotation
        R = R @ turned(joint.axis, angle)
        found.append((R, p, R @ joint.axis))
    return found

def of_body(k, found):
    R, p, _ = found[k]
    body, n = robot.bodies[k], len(found)
    mass = body.mass
    com = R @ body.com
    I = body.inertia
    inertia = R @ I @ R.T
    Jv, Jw = np.zeros((3, n)), np.zeros((3, n))
    for i, (_, place, axis) in enumerate(found[: k + 1]):
        Jv[:, i] = np.cross(axis, p + com - place)
        Jw[:, i] = axis
    return mass, com, inertia, Jv, Jw

def mass_matrix(q):
    found, M = frames(q), 0
    for k in range(len(found)):
        mass, com, inertia, Jv, Jw = of_body(k, found)
        M = M + mass * Jv.T @ Jv + Jw.T @ inertia @ Jw
    return M

def bias(q, v):
    found, h = frames(q), 0
    w, dw, a, last = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    for k, (_, p, axis) in enumerate(found):
        mass, com, inertia, Jv, Jw = of_body(k, found)
        a = a + np.cross(dw, p - last) + np.cross(w, np.cross(w, p - last))
        dw = dw + np.cross(w, axis * v[k])
        w, last = w + axis * v[k], p
        ac = a + np.cross(dw, com) + np.cross(w, np.cross(w, com))
        h = h + mass * Jv.T @ ac + Jw.T @ (inertia @ dw + np.cross(w, inertia @ w))
    return h

def gravity(q):
    found, G = frames(q), 0
    for k in range(len(found)):
        mass, com, inertia, Jv, Jw = of_body(k, found)
        G = G - mass * Jv.T @ down
    return G
"""
TURN = (0.4, -0.3, 0.7)
LINKS = chains.urdf(
    chains.link("base"),
    chains.link("a", chains.Solid(4.0, (0.05, 0.02, 0.3), (0.3, 0.01, 0.02, 0.28, 0.03, 0.1))),
    chains.link("b", chains.Solid(3.0, (0.2, -0.03, 0.04), (0.05, 0.01, -0.006, 0.2, 0.008, 0.18))),
    chains.link(
        "c", chains.Solid(1.5, (0.1, 0.04, -0.02), (0.02, 0.004, 0.003, 0.05, -0.002, 0.06))
    ),
    chains.joint("j1", "base", "a", at=(0.1, 0.0, 0.2)),
    chains.joint("j2", "a", "b", axis=(0, 1, 0), at=(0.0, 0.1, 0.5), rpy=TURN),
    chains.joint("j3", "b", "c", axis=(0, 1, 0), at=(0.45, 0.02, 0.0), rpy=(-0.2, 0.5, 0.3)),
)
GANTRY = """
down, multiplier, offset = robot.gravity, -0.8, 0.2
E = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0], [0, 0, multiplier]])

def turned(axis, angle):
    K = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K

def frames(q):
    R, p, found = np.eye(3), np.zeros(3), []
    for k, (joint, x) in enumerate(zip(robot.joints, E @ q + [0, 0, 0, offset], strict=True)):
        place, turn, own = joint.placement.position, joint.placement.rotation, joint.axis
        p = p + R @ place
        R = R @ turn
        axis = R @ own
        if joint.kind == "prismatic":
            p = p + axis * x
        else:
            R = R @ turned(own, x)
        found.append((R, p, axis))
    return found

def of_body(k, found):
    R, p, _ = found[k]
    body = robot.bodies[k]
    mass, com, I = body.mass, body.com, body.inertia
    com = R @ com
    Jv, Jw = np.zeros((3, 4)), np.zeros((3, 4))
    for i, (_, place, axis) in enumerate(found[: k + 1]):
        if robot.joints[i].kind == "prismatic":
            Jv[:, i] = axis
        else:
            Jv[:, i], Jw[:, i] = np.cross(axis, p + com - place), axis
    return mass, com, R @ I @ R.T, Jv, Jw

def mass_matrix(q):
    found, M = frames(q), 0
    for k in range(4):
        mass, com, inertia, Jv, Jw = of_body(k, found)
        M = M + mass * Jv.T @ Jv + Jw.T @ inertia @ Jw
    return E.T @ M @ E

def bias(q, v):
    found, h, rates = frames(q), 0, E @ v
    w, dw, a, last = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    for k, (_, p, axis) in enumerate(found):
        mass, com, inertia, Jv, Jw = of_body(k, found)
        a = a + np.cross(dw, p - last) + np.cross(w, np.cross(w, p - last))
        if robot.joints[k].kind == "prismatic":
            a = a + 2 * np.cross(w, axis * rates[k])
        else:
            dw = dw + np.cross(w, axis * rates[k])
            w = w + axis * rates[k]
        last = p
        ac = a + np.cross(dw, com) + np.cross(w, np.cross(w, com))
        h = h + mass * Jv.T @ ac + Jw.T @ (inertia @ dw + np.cross(w, inertia @ w))
    return E.T @ h

def gravity(q):
    found, G = frames(q), 0
    for k in range(4):
        mass, com, inertia, Jv, Jw = of_body(k, found)
        G = G - mass * Jv.T @ down
    return E.T @ G
"""
FOLLOW = chains.LIMIT + '<mimic joint="j3" multiplier="-0.8" offset="0.2"/>'
COLUMN = chains.urdf(
    chains.link("base"),
    chains.link("a", chains.Solid(4.0, (0.05, 0.02, 0.3), (0.3, 0.01, 0.02, 0.28, 0.03, 0.1))),
    chains.link("b", chains.Solid(3.0, (0.2, -0.03, 0.04), (0.05, 0.01, -0.006, 0.2, 0.008, 0.18))),
    chains.link(
        "c", chains.Solid(1.5, (0.1, 0.04, -0.02), (0.02, 0.004, 0.003, 0.05, -0.002, 0.06))
    ),
    chains.link(
        "d", chains.Solid(0.6, (0.02, -0.01, 0.07), (0.008, 0.001, 0.0, 0.007, -0.0005, 0.002))
    ),
    chains.joint("j1", "base", "a", at=(0.1, 0.0, 0.2)),
    chains.joint("j2", "a", "b", "prismatic", (0.6, 0.0, 0.8), (0.0, 0.1, 0.5), TURN),
    chains.joint("j3", "b", "c", axis=(0, 1, 0), at=(0.45, 0.02, 0.0), rpy=(-0.2, 0.5, 0.3)),
    chains.joint("j4", "c", "d", axis=(1, 0, 0), at=(0.1, 0.0, 0.15), more=FOLLOW),
)
TEXTS: dict[str, tuple[str, Callable[[], Robot]]] = {
    "two-link": (TWO_LINK, two_link.robot),
    "cart-pole": (CART_POLE, test_trial_motors.cart_pole),
    "spatial": (SPATIAL, lambda: chains.robot(LINKS)),
    "gantry": (GANTRY, lambda: chains.robot(COLUMN)),
}


FOLDER = Path(__file__).with_name("source_edits")
ROBOTS: dict[str, Callable[[], Robot]] = {
    "puma560": lambda: load_robot("puma560"),
    "three joints": lambda: chains.robot(LINKS),
}
PAIRS = 200  # right models


ROWS = tomllib.loads(Path(__file__).with_name("robot_slips.toml").read_text(encoding="utf-8"))
SLIPS = [Mistake(**row) for row in ROWS["slips"]]


class Score(NamedTuple):
    """What a trial made of a slip: caught, right entries, right cause; all its texts."""

    caught: bool
    entries: bool
    cause: bool
    texts: list[str]


def try_text(kind: str, replaced: tuple[tuple[str, str], ...] = ()) -> Trial:
    """The trial of a text with pieces replaced, each of which must be in it."""
    text, make_robot = TEXTS[kind]
    for old, new in replaced:
        if old not in text:
            raise ValueError(f"{kind}: no {old!r} in the text")
        text = text.replace(old, new)
    robot = make_robot()
    names: dict[str, Any] = {"np": np, "robot": robot}
    exec(compile(text, f"<{kind}>", "exec"), names)
    parts = ("mass_matrix", "bias", "gravity", "acceleration", "drive", "viscous_friction")
    own = {name: names[name] for name in parts if name in names}
    return run_robot_trial(build_robot_equations(SimpleNamespace(**own), robot, None, kind), robot)


def score_slip(slip: Mistake) -> Score:
    """Try a slip."""
    trial = try_text(slip.kind, slip.replaced)
    found = trial.diagnosis
    names = [entry.name for entry in found.entries]
    remarks = [f"{entry.name}: {entry.remark}" for entry in found.entries if entry.remark]
    texts = [*found.readings, *found.notes, *found.explanations, *remarks]
    return Score(
        not trial.agrees,
        bool(names) and all(re.fullmatch(slip.entry, name) for name in names),
        any(re.search(slip.term, line) for line in texts),
        [*names, *texts],
    )


class CodeEdit(NamedTuple):
    """A wrong edit of a code: the pieces of text."""

    file: str
    mechanism: str
    name: str
    right: str
    wrong: str
    held_out: bool = False

    @property
    def text(self) -> str:
        """The code with the edit. Raises ValueError for a piece that is not in it."""
        whole = self.right_text
        if self.right not in whole:
            raise ValueError(f"{self.file}: no {self.right!r} in the text")
        return whole.replace(self.right, self.wrong, 1)

    @property
    def right_text(self) -> str:
        """The code as it is right."""
        return (FOLDER / self.file.partition(":")[0]).read_text(encoding="utf-8")

    @property
    def lines(self) -> range:
        """Numbers of the lines that are wrong."""
        rows = zip(self.text.splitlines(), self.right_text.splitlines(), strict=False)
        first = next(number for number, (a, b) in enumerate(rows, 1) if a != b)
        removed = self.right_text.count("\n") - self.text.count("\n")
        return range(first - removed, first + 1)


LEVELS = ("links", "carriers", "armature", "coupled")
LENGTH_M = 0.05  # of a displacement beside a radian
WORST = 5  # decades of condition


class Pair(NamedTuple):
    """Right equations: whose, on which arm, in which coordinates, of which kind."""

    kind: str
    arm: Arm
    model: str
    coordinates: Coordinates


def draw_pair(seed: int) -> Pair:
    """One at random."""
    draw = np.random.default_rng(seed)
    arm, gearing = random_arm(seed, most_joints=4), str(draw.choice(["rigid", "lumped", "free"]))
    engines = ["analytic:physical", "pinocchio:gears"]
    if gearing == "rigid":
        engines = [f"{engine}:{level}" for engine in ("analytic", "pinocchio") for level in LEVELS]
    kind = str(draw.choice([*MAPS]))
    return Pair(kind, arm, str(draw.choice(engines)), MAPS[kind](draw, arm, gearing))


def _sizes(arm: Arm, gearing: str) -> np.ndarray:
    return np.where(LAYOUTS[gearing](arm).angular, 1.0, LENGTH_M)


def _draw_rotation(draw: np.random.Generator, n: int) -> np.ndarray:
    return np.linalg.qr(draw.normal(size=(n, n)))[0]


def draw_named(draw: np.random.Generator, arm: Arm, gearing: str) -> Coordinates:
    """Absolute or relative, displacements or gear angles."""
    links, gears = draw.choice(["relative", "absolute"]), draw.choice(["displacements", "angles"])
    return Coordinates(gearing, str(links), str(gears))


def draw_matrix(draw: np.random.Generator, arm: Arm, gearing: str) -> Coordinates:
    """A full matrix of a condition up to 1e5."""
    sizes = _sizes(arm, gearing)
    spread = np.geomspace(1, 10 ** -draw.uniform(0, WORST), sizes.size)
    full = _draw_rotation(draw, sizes.size) * spread @ _draw_rotation(draw, sizes.size)
    return Coordinates(gearing, matrix=sizes[:, None] * full)


def draw_units(draw: np.random.Generator, arm: Arm, gearing: str) -> Coordinates:
    """Coordinates in millionths and millions."""
    sizes = _sizes(arm, gearing)
    lower = np.tril(draw.normal(size=(sizes.size, sizes.size))) + 2 * np.eye(sizes.size)
    scaled = lower * 10 ** draw.uniform(-6, 6, sizes.size)
    return Coordinates(gearing, matrix=sizes[:, None] * scaled)


def draw_order(draw: np.random.Generator, arm: Arm, gearing: str) -> Coordinates:
    """The project's, in another order."""
    n = len(LAYOUTS[gearing](arm))
    return Coordinates(gearing, matrix=np.eye(n)[draw.permutation(n)])


def draw_curved(draw: np.random.Generator, arm: Arm, gearing: str) -> Coordinates:
    """A function that bends every coordinate and mixes them."""
    sizes = _sizes(arm, gearing)
    bends = draw.uniform(0.1, 0.6, sizes.size)
    mixed = np.eye(sizes.size) + 0.2 * np.tril(draw.normal(size=(sizes.size, sizes.size)), -1)
    return Coordinates(gearing, function=lambda x: sizes * (mixed @ (x + bends * np.sin(x))))


MAPS = {
    "named": draw_named,
    "matrix": draw_matrix,
    "units": draw_units,
    "order": draw_order,
    "curved": draw_curved,
}


def find_false_alarms(pair: Pair) -> list[str]:
    """The checks that are red and the entries that are called wrong."""
    moved = in_frame(pair.model, pair.coordinates, pair.arm, make_unequal_gains_scenario(pair.arm))
    equations = replace(equations_of(moved), coordinates=pair.coordinates)
    trial = try_equations(equations, pair.arm)
    red = [finding.id for finding in trial.agreement.disagreeing]
    return red + [each.name for each in trial.wrong]


class Outcome(NamedTuple):
    """What a trial made of equations; None where the set does not ask.

    seen: whether the mistake shows; entries: whether none but wrong entries are named; named: the
    cause, or the line of code; blamed: whether right equations differ.
    """

    seen: bool | None = None
    entries: bool | None = None
    named: bool | None = None
    blamed: bool | None = None


def try_mistake(mistake: Mistake) -> Outcome:
    """The outcome of a mistake in an arm's equations."""
    found = scored(mistake)
    return Outcome(bool(found.entries), found.entry_right, found.verdict == "right")


def try_slip(slip: Mistake) -> Outcome:
    """The outcome of a slip in a robot's equations."""
    return Outcome(*score_slip(slip)[:3])


def list_edits() -> Iterator[CodeEdit]:
    """All wrong edits of natural code."""
    rows = tomllib.loads((FOLDER / "slips.toml").read_text(encoding="utf-8"))
    for code in rows["code"]:
        for row in code["slips"]:
            yield CodeEdit(code["file"], code["mechanism"], **row)


def try_edit(edit: CodeEdit) -> Outcome:
    """The outcome of a wrong edit: whether its line is named first."""
    file, _, name = edit.file.partition(":")
    mechanism: Any = str(FOLDER / edit.mechanism)
    if edit.mechanism in ROBOTS:
        mechanism = ROBOTS[edit.mechanism]()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / file
        path.write_text(edit.text, encoding="utf-8")
        trial = try_equations(f"{path}:{name}", mechanism)
    change = trial.change
    is_named = change is not None and not change.wrong and change.edits[0].line in edit.lines
    return Outcome(trial.exit_code != 0, None, is_named)


def try_right(seed: int) -> Outcome:
    """The outcome of right equations."""
    return Outcome(blamed=bool(find_false_alarms(draw_pair(seed))))


SETS: dict[str, tuple[list[Any], Callable[[Any], Outcome], int]] = {  # rows, and a sample's step
    "arms": (MISTAKES, try_mistake, 25),
    "robots": (SLIPS, try_slip, 6),
    "code": (list(list_edits()), try_edit, 16),
    "right models": (list(range(PAIRS)), try_right, 40),
    "right texts": ([*TEXTS], lambda kind: Outcome(blamed=not try_text(kind).agrees), 2),
}


def main(*words: str) -> None:
    """Print the table."""
    titles = "seen", "entries", "cause or line", "blamed"
    print(f"{'set':14}{'tried':>6}", *(f"{title:>14}" for title in titles), f"{'s':>7}")
    for name, (rows, attempt, step) in SETS.items():
        word = next((each for each in words if each != "--all"), "")
        chosen = [row for row in rows if word in getattr(row, "name", str(row))]
        chosen = chosen if word or "--all" in words else chosen[::step]
        begun = time.perf_counter()
        outcomes = [attempt(row) for row in chosen]
        seconds = time.perf_counter() - begun
        counts = []
        for values in zip(*outcomes, strict=True):
            known = [each for each in values if each is not None]
            counts.append(f"{sum(known)} of {len(known)}" if known else "")
        print(f"{name:14}{len(chosen):6}", *(f"{each:>14}" for each in counts), f"{seconds:7.0f}")
        for row, outcome in zip(chosen, outcomes, strict=True):
            if False in outcome[:3] or outcome.blamed:
                print(f"    {getattr(row, 'name', row)}: {outcome}")


if __name__ == "__main__":
    main(*sys.argv[1:])
