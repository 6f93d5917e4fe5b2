"""Recordings whose drives have other gains than stated, and encoders other zeros."""

from dataclasses import replace

import numpy as np

from crosscheck.identification import compare
from crosscheck.identification.compare import RecordComparison
from crosscheck.identification.mechanism import SpatialRobot
from crosscheck.identification.refinement import Knowledge, Refinement, refine
from crosscheck.identification.terms import TermEstimate
from crosscheck.models.robot.robot import Robot
from crosscheck.recordings.record import Record
from tests.measured.records import first_problem
from tests.measured.robots import RATIO, ROTOR, arm, draw_arm, recording

SECONDS = 8.0
SHARE = 0.02  # to which links are known
ZEROS = np.array([0.0, 0.03, -0.05])  # the first joint's is shown by nothing
TIMES = 1.25  # the stated torque of the true one: the gain is 0.8 of the stated one


def ask(robot: Robot, given: Record, knowledge: Knowledge) -> RecordComparison:
    """What the recording says with what is known."""
    return compare.compare(
        SpatialRobot(robot), [given], np.eye(3), lambda *progress: None, knowledge
    )


def refine_alone(robot: Robot, given: Record, knowledge: Knowledge) -> tuple[float, Refinement]:
    """The bandwidth, and the refinement of a recording of motors' torques, without all else."""
    problem = first_problem(robot, given)
    bandwidth = problem.choose_bandwidth()
    rows, _, full = problem.fit(bandwidth)
    return bandwidth, refine(compare._record_torque(problem, rows, full), knowledge)


def estimate_unknowns(seed: int) -> list[tuple[TermEstimate, float]]:
    """Estimates of gains, zeros and rotors of a recording, each with what is true.

    The links that move are not the file's: they are drawn as the prior says.
    """
    true = draw_arm(SHARE, seed)
    given = recording(true, "armature", seed, seconds=SECONDS, gain=TIMES, friction=0.5)
    given = replace(given, position=given.position - ZEROS)
    knowledge = Knowledge(SHARE, frozenset({"gains", "zeros"}))
    fit = refine_alone(replace(arm(), rotors=()), given, knowledge)[1].best
    assert fit.settled
    assert fit.contained == ("j1",)
    right = {f"drive gain of j{joint}": 1 / TIMES for joint in (1, 2, 3)}
    right |= {f"encoder zero of j{joint + 1}": float(ZEROS[joint]) for joint in (1, 2)}
    right |= {f"armature of j{joint}": RATIO**2 * ROTOR for joint in (1, 2, 3)}
    by_name = {each.term.name: each for each in fit.estimates}
    return [(by_name[name], value) for name, value in right.items()]
