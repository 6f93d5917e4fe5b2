"""Slips in a robot's equations, of kinds on record: how many does a trial tell right?

Run as ``python -m benchmarks.bench_robot_slips [WORD]`` from the project's folder: all slips of
robot_slips.toml, or those whose name has the word.
"""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.robot.robot import Robot
from crosscheck.trial.input.loading import build_robot_equations
from crosscheck.trial.robots.trial import RobotTrial
from tests.robots import chains, test_trial_motors, two_link
from tests.robots.trials import run_robot_trial

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


class Slip(NamedTuple):
    """A slip: pieces of a right text, and what stands there instead.

    source: where a slip of the kind is reported or corrected. entries: pattern of the entries that
    are wrong by it. cause: pattern of what must be told.
    """

    name: str
    source: str
    text: str
    replaced: tuple[tuple[str, str], ...]
    entries: str
    cause: str


ROWS = tomllib.loads(Path(__file__).with_name("robot_slips.toml").read_text(encoding="utf-8"))
SLIPS = [Slip(**row) for row in ROWS["slips"]]


class Score(NamedTuple):
    """What a trial made of a slip: caught, right entries, right cause; all that it told."""

    caught: bool
    entries: bool
    cause: bool
    told: list[str]


def try_text(kind: str, replaced: tuple[tuple[str, str], ...] = ()) -> RobotTrial:
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


def score_slip(slip: Slip) -> Score:
    """Try a slip."""
    trial = try_text(slip.text, slip.replaced)
    found = trial.diagnosis
    names = [entry.name for entry in found.entries]
    remarks = [f"{entry.name}: {entry.remark}" for entry in found.entries if entry.remark]
    told = [*found.readings, *found.notes, *found.explanations, *found.links, *remarks]
    return Score(
        not trial.agrees,
        bool(names) and all(re.fullmatch(slip.entries, name) for name in names),
        any(re.search(slip.cause, line) for line in told),
        [*names, *told],
    )


def main(word: str = "") -> None:
    """Print each slip, and the shares."""
    for kind in TEXTS:
        print(f"{kind} as it is: {'agrees' if try_text(kind).agrees else 'IS BLAMED'}")
    chosen = [slip for slip in SLIPS if word in slip.name]
    scores = [score_slip(slip) for slip in chosen]
    for slip, score in zip(chosen, scores, strict=True):
        marks = "".join("+" if good else "-" for good in score[:3])
        print(f"{marks} {slip.text}: {slip.name}")
        if not all(score[:3]):
            print(*(f"      {line}" for line in score.told[:12]), sep="\n")
    for place, what in enumerate(("caught", "right entries", "right cause")):
        print(f"{what}: {sum(score[place] for score in scores)} of {len(scores)}")


if __name__ == "__main__":
    main(*sys.argv[1:])
