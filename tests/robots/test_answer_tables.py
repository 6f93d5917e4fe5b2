"""A robot's equations as a table of answers, as any other tool would answer it."""

from pathlib import Path

import numpy as np
import pytest

from crosscheck.models.robot.file import load_robot
from crosscheck.registry import build_robot_model
from crosscheck.trial.input.calls import TAKES
from crosscheck.trial.tables.robot_requests import RobotTableTrial
from crosscheck.trial.tables.state_requests import (
    StateRequest,
    collect_inverse_requests,
    collect_state_request,
)
from tests.tool.test_bad_input import assert_one_line
from tests.trial.other_tools.tables import write_csv

Values = dict[str, np.ndarray]
METHODS = {"acceleration": "forward_dynamics"}
SEPARATE = ("mass_matrix", "bias", "gravity")


def ask(robot: str) -> list[StateRequest]:
    trial = RobotTableTrial(load_robot(robot))
    states = collect_state_request(trial)
    return [states, *collect_inverse_requests(trial, states)]


def answer(asked: StateRequest, parts: tuple[str, ...]) -> Values:
    """What Pinocchio answers, NaN in rows where a part is not looked up."""
    model = build_robot_model("pinocchio", asked.arm, "coupled")
    values = {}
    for part in parts:
        rows = asked.needed[part]
        values[part] = np.full((asked.count, *asked.shape(part)), np.nan)
        if rows.any():
            given = {name: asked.arguments[name][rows] for name in TAKES[part] if name != "t"}
            if part == "force":
                values[part][rows] = given["torque"] - model.gravity(given["x"])
            else:
                values[part][rows] = getattr(model, METHODS.get(part, part))(*given.values())
    return values


@pytest.fixture(scope="module")
def puma() -> tuple[StateRequest, Values]:
    (states, _) = ask("puma560")
    return states, answer(states, SEPARATE)


def try_table(crosscheck, folder: Path, sheets, robot: str = "puma560"):
    file = write_csv(folder / "answers.csv", sheets)
    return crosscheck("trial", "--answers", file, robot)


def test_inverse_dynamics_is_asked_up_to_a_number_of_coordinates(puma, monkeypatch):
    (states, _) = puma
    for most, count in ((6, 1), (5, 0)):
        monkeypatch.setattr(RobotTableTrial, "most_coordinates", most)
        assert len(collect_inverse_requests(RobotTableTrial(states.arm), states)) == count


@pytest.mark.parametrize("robot", ["sliding", "examples/space/space-arm.toml"])
@pytest.mark.parametrize(
    "parts", [("mass_matrix", "bias", "force", "acceleration"), ("inverse_dynamics",)]
)
def test_every_part_may_be_answered(crosscheck, tmp_path, parts, robot):
    """Of a robot that floats with torques of 0 where it has no motor."""
    states, *apart = ask(robot)
    passive = states.arm.passive
    assert states.arguments["torque"].any()
    assert not states.arguments["torque"][:, passive].any()
    sheets = [(each, answer(each, parts)) for each in (states, *apart)]
    done = try_table(crosscheck, tmp_path, sheets, robot)
    assert done.code == 0, done.out + done.err


def test_another_answer_to_the_same_state_is_reported(crosscheck, tmp_path, puma):
    """A state that comes twice has two rows, and both are looked at."""
    states, values = puma
    again = [row for call, row in states.row_of.items() if call.again and call.part == "gravity"]
    wrong = values["gravity"].copy()
    wrong[again] *= 1.001
    done = try_table(crosscheck, tmp_path, [(states, {**values, "gravity": wrong})])
    assert done.code == 1
    assert "repeatable-gravity" in done.out


def test_a_torque_that_is_nowhere_is_reported(crosscheck, tmp_path):
    states = ask("sliding")[0]
    values = answer(states, ("mass_matrix", "bias", "force"))
    asked = states.needed["force"]
    model = build_robot_model("pinocchio", load_robot("sliding"), "coupled")
    values["force"][asked, 0] = -model.gravity(states.arguments["x"][asked])[:, 0]
    done = try_table(crosscheck, tmp_path, [(states, values)], "sliding")
    assert done.code == 1
    assert "where there is no motor, answer gravity for force" in done.out


def test_a_table_of_single_precision_is_refused(crosscheck, tmp_path, puma):
    states, values = puma
    short = {part: np.float64(np.float32(each)) for part, each in values.items()}
    file = write_csv(tmp_path / "answers.csv", [(states, short)])
    assert_one_line(crosscheck("trial", "--answers", file, "puma560"), "12 digits are needed")


def test_states_of_another_seed_are_refused(crosscheck, tmp_path):
    """The folder's own file of states, with answers beside, is a table too."""
    folder = tmp_path / "ask"
    done = crosscheck("trial", "--ask", "sliding", "--out", folder)
    assert done.code == 0, done.err
    assert "for the robot sliding" in (folder / "README.md").read_text()
    states = ask("sliding")[0]
    gravity = answer(states, ("gravity",))["gravity"]
    lines = (folder / "states.csv").read_text().splitlines()
    assert "torque_swivel_N_m,torque_slide_N,torque_tilt_N_m" in lines[0]
    table = [lines[0] + "".join(f",gravity_{n + 1}" for n in range(gravity.shape[1]))]
    for line, values in zip(lines[1:], gravity, strict=True):
        table.append(",".join([line, *("" if np.isnan(x) else repr(float(x)) for x in values)]))
    file = folder / "answers.csv"
    file.write_text("\n".join(table))
    assert crosscheck("trial", "--answers", file, "sliding").code == 0
    refused = crosscheck("trial", "--answers", file, "sliding", "--seed", "1")
    assert_one_line(refused, ": answers to other states: must be ")
