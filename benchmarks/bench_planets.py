"""What a step of the analytic model costs, by the number of its meshes.

Run as ``python benchmarks/bench_planets.py`` from the project's folder. Processor time, the least
of several runs: a machine that does other things beside makes a run longer, never shorter.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

from crosscheck.registry import build, lead
from crosscheck.template import example_arm
from models.arm import Arm, Planetary
from models.loading import load_scenario
from models.scenario import Scenario
from models.switches import switches

STEPS, STEP_S, REPEATS = 20_000, 1e-6, 7
HEAD = f"{'joints':>6}{'planets':>8}  {'':<7}{'meshes':>7}{'us a step':>11}{'us a mesh':>11}"


class Cost(NamedTuple):
    """Of an arm of so many joints with so many planets each: meshes, and a step [us]."""

    joints: int
    planets: int
    counted: str
    meshes: int
    step_us: float

    def __str__(self) -> str:
        each = self.step_us / self.meshes
        head = f"{self.joints:>6}{self.planets:>8}  {self.counted:<7}{self.meshes:>7}"
        return f"{head}{self.step_us:>11.2f}{each:>11.3f}"


def arm_of(joints: int, planets: int) -> Arm:
    """The template's arm with as many planets in every joint, whether or not they would clear."""
    arm = example_arm("planets", joints)
    stages = tuple(joint.model_copy(update={"planet_count": planets}) for joint in arm.joints)
    return arm.model_copy(update={"joints": stages})


def cost(joints: int, planets: int, counted: str) -> Cost:
    """Of the fastest of several runs."""
    arm = arm_of(joints, planets)
    model = build(lead(), arm, _scenario(), switches(planets=counted))
    model.simulate()
    used = min(_run(model.simulate) for _ in range(REPEATS))
    single = sum(2 * joint.planet_count for joint in arm.joints if isinstance(joint, Planetary))
    meshes = single if counted == "free" else 2 * joints
    return Cost(joints, planets, counted, meshes, 1e6 * used / STEPS)


def _run(simulate: Callable[[], object]) -> float:
    began = time.process_time()
    simulate()
    return time.process_time() - began


def _scenario() -> Scenario:
    update = {"duration_s": STEPS * STEP_S, "step_s": STEP_S, "record_every": STEPS}
    return load_scenario("constant-torque").model_copy(update=update)


def costs() -> Iterator[Cost]:
    """More joints, then more planets."""
    for joints in range(1, 7):
        for counted in ("lumped", "free"):
            yield cost(joints, 3, counted)
    for planets in range(2, 7):
        yield cost(3, planets, "free")


if __name__ == "__main__":
    print(HEAD)
    for each in costs():
        print(each)
