"""Every number of a trial's views, read back: of an arm's equations, and of a robot's.

Two numbers are wrong by what is known here; sizes follow from right answers at the trial's states.
"""

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import load_scenario
from crosscheck.report.trials import output
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.result import TrialResult
from crosscheck.trial.robots.trial import RobotTrial
from crosscheck.trial.trial import Trial, run_arm_trial
from tests.faults.views import Views, cell_text, finding_problems, rows_of
from tests.robots import two_link
from tests.robots.trials import run_robot_trial
from tests.trial.test_judge_table import two_link as two_link_arm
from tests.trial.test_trial import equations_of, in_frame

NAME, LEVELS = "yours", ("links", "carriers")  # that differ on an arm with motors and no gears
INERTIA, MOMENT, SHARED = 0.0123, 3.7, 0.0045  # that are too much in M and force, and in M[0, 1]


def moment_at(x: np.ndarray) -> np.ndarray:
    """What is too much in the force: another moment in every pose."""
    return np.array([0.0, MOMENT * np.cos(7 * x[0])])


def wrong_equations(arm: Arm, scenario: Scenario) -> Equations:
    """Of a rigid arm: more inertia at the first joint, and a moment at the second."""
    moved = in_frame("analytic:links", Coordinates("rigid"), arm, scenario)
    right = equations_of(moved)
    return replace(
        right,
        mass_matrix=lambda x: moved.mass_matrix(x) + np.diag([INERTIA, 0.0]),
        force=lambda t, x, v, torque: right.force(t, x, v, torque) + moment_at(x),
        coordinates=Coordinates("rigid"),
        rebuild=wrong_equations,
    )


def tried_arm() -> Trial:
    """The trial of these equations."""
    arm = two_link_arm()
    own = wrong_equations(arm, load_scenario("pd"))
    return run_arm_trial(TrialRequest(NAME, own, arm, quick=True))


kept_arm = lru_cache(tried_arm)


@lru_cache
def right_shares(states: int) -> dict[str, np.ndarray]:
    """How far M is off, and the force, by their sizes over the trial's states."""
    arm, scenario, problem = two_link_arm(), load_scenario("pd"), kept_arm().problem
    assert states == len(problem.states)
    placed = [np.asarray(state.x) for state in problem.states]
    moved = in_frame("analytic:links", Coordinates("rigid"), arm, scenario)
    mass = np.array([moved.mass_matrix(x) for x in placed])
    own = mass + np.diag([INERTIA, 0.0])
    root = np.sqrt(mass[:, [0, 1], [0, 1]].max(axis=0))
    model = in_frame("analytic:links", Coordinates("rigid"), arm, problem.case.scenario)
    forces = [
        model.model.generalized_force(state.t, np.asarray(state.x), np.asarray(state.v))
        for state in problem.states
    ]
    rms = np.sqrt((np.array(forces) ** 2).mean(axis=0))
    moments = np.max([np.abs(moment_at(x)) for x in placed], axis=0)
    shares = np.abs(own - mass).max(axis=0) / np.outer(root, root)
    return {"M": shares, "force": moments / rms}


def wrong_arm_views(trial: Trial) -> Iterator[str]:
    """Numbers of terminal, JSON, page and JUnit that are not those of the trial's equations."""
    shares = right_shares(len(trial.problem.states))
    entries = {"M[theta_1, theta_1]": shares["M"][0, 0], "force[theta_2]": shares["force"][1]}
    rows = {"M": shares["M"], "force": shares["force"][:, None]}
    nearest = "links", len(entries), max(entries.values())
    yield from wrong_views(trial, entries, [nearest], rows)
    line = f"M[theta_1, theta_1]: yours minus right is {INERTIA:g};"
    if not any(cause.startswith(line) for cause in trial.answer.causes):
        yield f"no {line}"


def wrong_views(
    trial: TrialResult,
    entries: dict[str, float],
    levels: list[tuple[str, int, float]],
    rows: dict[str, np.ndarray],
) -> Iterator[str]:
    """Numbers of the views that differ from shares of entries, of levels, and of maps' rows."""
    answer = trial.answer
    data, page = json.loads(output.format_trial_json(answer)), output.render_trial_page(answer)
    told, suite = "\n".join(answer.lines), output.format_trial_junit(answer)
    read = Views(trial.agreement, told, data["agreement"], page, suite)
    yield from (each for each in finding_problems(read) if "the terminal" not in each)
    if {each["name"]: each["share"] for each in data["wrong"]} != pytest.approx(entries):
        yield f"JSON's wrong entries: {data['wrong']} for {entries}"
    found = [(each["level"], each["entries"], each["largest"]) for each in data["levels"]]
    for (name, count, largest), right in zip(found, levels, strict=False):
        if (name, count) != right[:2] or not np.isclose(largest, right[2], rtol=1e-6):
            yield f"level {name}, {count}, {largest}; must be {right}"
    by = re.search(r"wrong, by up to (\S+ %) of", answer.headline)
    if by is None or by[1] != cell_text(max(entries.values()), 0.0):
        yield f"the headline says {by and by[1]}, must be {max(entries.values())}"
    yield from _wrong_tables(page, entries)
    yield from _wrong_maps(page, rows, list(answer.coordinates), 1e-10)
    off = {row["entry"]: row["relative"] for row in answer.rows}
    for title, values in rows.items():
        for place, share in np.ndenumerate(values):
            names = [answer.coordinates[k] for k in place[: 2 if values.shape[1] > 1 else 1]]
            entry = f"{title}[{', '.join(names)}]"
            if not np.isclose(off[entry], share, rtol=1e-6, atol=1e-9):
                yield f"table of entries: {entry} is not off by {share}"


def _wrong_tables(page: str, entries: dict[str, float]) -> Iterator[str]:
    """Of the page's first table: entries with per cent, the largest first or as they stand."""
    columns = "<th>entry</th><th>off by</th><th>why</th>"
    table = page.partition(columns)[2].partition("</table>")[0]
    told = {row[0]: row[1] for row in rows_of(table) if len(row) > 1}
    right = {name: cell_text(share, 0.0) for name, share in entries.items()}
    if told != right:
        yield f"page's wrong entries: {told}, must be {right}"


def _wrong_maps(
    page: str, rights: dict[str, np.ndarray], names: list[str], tolerance: float
) -> Iterator[str]:
    """Of the heat maps, and of what is allowed."""
    for title, right in rights.items():
        found = re.search(rf"<caption>{title}</caption>(.*?)</table>", page, re.S)
        rows = rows_of(found[1]) if found else []
        texts = [
            [name, *(cell_text(v, tolerance) for v in row)]
            for name, row in zip(names, right, strict=True)
        ]
        if rows[1:] != texts:
            yield f"map of {title}: {rows[1:]}, must be {texts}"
        allowed = re.search(rf"rounding explains \(.*\b{title} ([\d.e-]+)", page)
        if allowed is None or not np.isclose(float(allowed[1]), tolerance, rtol=6e-3, atol=0):
            yield f"allowed of {title}: {allowed and allowed[1]}"


def tried_robot() -> RobotTrial:
    """Of the pendulum: M[j1, j2] and gravity[j2] are off by known shares of their sizes."""
    zero = np.zeros(2)

    def mass_matrix(q: np.ndarray) -> np.ndarray:
        off = INERTIA * two_link.sizes("mass_matrix", q, zero, zero, zero)[0, 1]
        return two_link.mass_matrix(q) + np.array([[0.0, off], [off, 0.0]])

    def gravity(q: np.ndarray) -> np.ndarray:
        off = SHARED * two_link.sizes("gravity", q, zero, zero, zero)[1]
        return two_link.gravity(q) - np.array([0.0, off])

    return run_robot_trial(
        two_link.right(mass_matrix=mass_matrix, gravity=gravity), two_link.robot()
    )


kept_robot = lru_cache(tried_robot)
ROBOT_ENTRIES = {"M[j1, j2]": INERTIA, "gravity[j2]": SHARED}


def wrong_robot_views(trial: RobotTrial) -> Iterator[str]:
    """Numbers of the views that are not those of the robot's equations."""
    rows = {"M": np.array([[0, INERTIA], [INERTIA, 0]]), "gravity": np.array([[0], [SHARED]])}
    yield from wrong_views(trial, ROBOT_ENTRIES, [("armature", 2, INERTIA)], rows)
    nearest = trial.distances[0]  # of four entries of M, two of the bias and two of gravity
    if not np.isclose(nearest.mean, (2 * INERTIA + SHARED) / 8, rtol=1e-6):
        yield f"mean share of the nearest level: {nearest.mean}"


GUARDS: dict[str, Callable[[], Iterator[str]]] = {
    "arm": lambda: wrong_arm_views(tried_arm()),
    "arm's views": lambda: wrong_arm_views(kept_arm()),
    "robot": lambda: wrong_robot_views(tried_robot()),
    "robot's views": lambda: wrong_robot_views(kept_robot()),
}
