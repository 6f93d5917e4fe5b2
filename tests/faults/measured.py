"""What `compare` says while a fault is in it: by a second program, stage by stage."""

from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from crosscheck.identification import engines
from crosscheck.models.pinocchio.robot import PinocchioRobot
from crosscheck.planning.comparison import Results
from crosscheck.recordings import record
from tests.brief import perform_here
from tests.faults.planting import Seen, judge_guard
from tests.measured import guards


def numbers_agree(seen: Seen) -> str:
    """The numbers of a stage."""
    with pytest.MonkeyPatch.context() as patch:
        perform_here(patch)
        guards.kept()
        return judge_guard(STAGES[seen.quantity]())


@lru_cache
def _size() -> float:
    """The largest sum of the sizes of what a link's numbers make of joint 2's torque [N m]."""
    motion = _motion()
    robot = guards.kept().comparison.mechanism.robot
    return float(engines._measure_terms(robot, motion)[:, 1].max())


def _motion() -> engines.Motion:
    samples = guards.kept().comparison.sides[0].samples
    return samples.q, samples.v, samples.a


def _engines() -> Iterator[str]:
    """Pinocchio is off in one row by just less than the tolerance, by just more and by a tenth."""
    arm, right = guards.kept().comparison.mechanism, PinocchioRobot.inverse_dynamics
    level = arm.levels[-1]
    for share, verdict in ((0.95e-10, "agree"), (1.05e-10, "differ"), (0.1, "differ")):

        def harmed(
            self: PinocchioRobot, *state: np.ndarray, more: float = share * _size()
        ) -> np.ndarray:
            torques = right(self, *state)
            torques[1, 1] += more
            return torques

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(PinocchioRobot, "inverse_dynamics", harmed)
            for planned in engines.plan_level(arm, level, _motion()):
                answers = {task.key: task.perform() for task in planned.needs}
                finding = planned.finding(Results(answers))
                # The planar one is the same engine's.
                is_harmed = finding.right.startswith(f"pinocchio:{level.name}")
                if finding.verdict != (verdict if is_harmed else "agree"):
                    yield f"{share} of a torque: {finding}"
                if is_harmed:
                    yield from guards.apart("difference", finding.measured, share, 1e-2)


UNITS = (
    "t_ms,theta_1_deg,theta_2_deg,theta_dot_1_rpm,theta_dot_2_deg_per_s,torque_1_mN_m,torque_2_N_m"
)


def _reading() -> Iterator[str]:
    """A file in other units."""
    time = 0.1 * np.arange(64.0)
    angles, rates = np.column_stack([np.sin(time), np.cos(time)]), np.column_stack([time, -time])
    torques = np.column_stack([time**2, 3 * time])
    columns = [1e3 * time, *np.degrees(angles).T, rates[:, 0] * 30 / np.pi]
    columns += [np.degrees(rates[:, 1]), 1e3 * torques[:, 0], torques[:, 1]]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "record.csv"
        np.savetxt(path, np.column_stack(columns), delimiter=",", header=UNITS, comments="")
        found = record.read_record(path, 2)
    right = {"time": time, "position": angles, "rates": rates, "motor_torque": torques}
    for name, values in right.items():
        yield from guards.apart(name, getattr(found, name), values)


STAGES: dict[str, Callable[[], Iterator[str]]] = {
    "engines": _engines,
    "estimates": guards.wrong_estimates,
    "chances": guards.wrong_chances,
    "runs": guards.wrong_runs,
    "drive": guards.wrong_torques_of_a_drive,
    "choice": guards.wrong_choice,
    "reading": _reading,
}
