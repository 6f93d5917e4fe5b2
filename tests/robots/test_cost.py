"""What shortcuts cost: by closed forms where there are any, and as its user meets the command."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from crosscheck import file_types
from crosscheck.checks.robot_states import motion_range
from crosscheck.cli.files.robot_files import load_as_robot
from crosscheck.cli.files.template import make_plain_arm, template
from crosscheck.cost.output import (
    _describe_disagreements,
    _describe_identity,
    _tabulate_agreement,
    cost_page,
    describe_result,
)
from crosscheck.cost.shortcuts import QUICK, ShortcutCosts, compute_costs
from crosscheck.file_types import is_file_of_type
from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import Robot
from crosscheck.runner import tasks
from tests.robots import chains
from tests.robots.chains import Solid, geared, joint, link, planetary, robot, urdf
from tests.robots.cost_guard import found_cost
from tests.tool.test_bad_input import assert_one_line

FEW = replace(QUICK, states=3, instants=100, steps=20, most_steps=400)
SPIN, RATIO = 1e-3, 20.0


def cost(own: Robot, seed: int = 0) -> ShortcutCosts:
    return compute_costs(own, seed, FEW, lambda *doing: None)


def parallel(ratio: float = RATIO) -> Robot:
    """Two joints about z, no weight; the second one's rotor of constant reflected inertia."""
    text = urdf(
        link("ground"),
        link("upper", Solid(2.0, (0.3, 0, 0), (0.1, 0, 0, 0.1, 0, 0.1))),
        link("lower", Solid(1.0, (0.2, 0, 0), (0.1, 0, 0, 0.1, 0, 0.1))),
        joint("shoulder", "ground", "upper"),
        joint("elbow", "upper", "lower", at=(0.6, 0, 0)),
    )
    own = {"elbow": geared(ratio, SPIN * (RATIO / ratio) ** 2)}
    return robot(text, own, gravity_m_per_s2=[0.0, 0.0, 0.0])


def written(folder: Path, time: np.ndarray, angles: np.ndarray, slide: int = 0) -> Path:
    """A CSV file of a motion; slide: the number of a joint that slides, 0 for none."""
    joints = range(1, angles.shape[1] + 1)
    names = ["t_s", *(f"theta_{each}_{'m' if each == slide else 'rad'}" for each in joints)]
    table = np.column_stack([time, angles])
    np.savetxt(folder / "motion.csv", table, "%.17g", ",", header=",".join(names), comments="")
    return folder / "motion.csv"


def test_a_given_motion_beyond_the_limits_is_reported(crosscheck, tmp_path):
    time = np.linspace(0, 2, 400)
    angles = np.stack([3 * np.sin(3 * time), 0.3 + 0 * time, 0 * time], axis=1)
    answer = crosscheck(
        "cost", "sliding", "--quick", "--motion", written(tmp_path, time, angles, 2)
    )
    assert answer.code == 0
    assert "swivel: velocity of 9 is beyond its limit, 2" in answer.out
    assert "swivel: leaves its range" in answer.out
    assert "slide: leaves" not in answer.out


def test_a_given_motion_that_is_too_short_is_refused(crosscheck, tmp_path):
    angles = np.linspace(0, 0.1, 400)[:, None] * np.ones(3)
    file = written(tmp_path, np.linspace(5, 5.5, 400), angles, 2)
    assert_one_line(crosscheck("cost", "sliding", "--motion", file), "motion.csv", "1.1 s at least")
    few = written(tmp_path, np.linspace(0, 2, 400), angles[:, :2], 2)
    assert_one_line(crosscheck("cost", "sliding", "--motion", few), "motion.csv", "theta_3")
    none = written(tmp_path, np.linspace(0, 2, 400), angles[:, :0])
    assert_one_line(crosscheck("cost", "sliding", "--motion", none), "has no angles; columns")


def test_a_rotor_that_turns_about_a_fixed_axis_costs_nothing_as_armature():
    text = urdf(link("ground"), link("arm", Solid()), joint("swing", "ground", "arm"))
    lines = describe_result(cost(robot(text, {"swing": geared(9.0)})))
    assert "Counting them as armature only changes no torque." in lines
    (said,) = _describe_identity(parallel())  # whose other joint has no rotor
    assert "At every joint the stator" in said


def test_names_of_any_characters_are_drawn_and_shown():
    names = ["a$b_{x", "<script>", "\u00fcnder"]
    text = urdf(
        link("ground"),
        *(link(f"link {number}", Solid()) for number in range(3)),
        *(
            joint(name.replace("<", "&lt;"), "ground" if n == 0 else f"link {n - 1}", f"link {n}")
            for n, name in enumerate(names)
        ),
    )
    found = cost(robot(text, {name: geared(9.0) for name in names}))
    assert found.names == tuple(names)
    assert "<script>" not in cost_page(found)


def test_gears_too_unlike_for_the_digits_are_one_line():
    """A tolerance that grows with M's condition number must not let any answers agree."""
    text = parallel().urdf
    with pytest.raises(InputError, match="too different for 16 digits"):
        cost(robot(text, {"elbow": planetary(planet_inertia_kg_m2=1e15)}))


def test_a_robot_without_rotors_is_refused_at_once_and_options_state_them(crosscheck, tmp_path):
    """The refusal names what each joint lacks; options fill in what the URDF does not state."""
    gear = "<transmission><joint name='elbow'/><mechanicalReduction>50</mechanicalReduction>"
    (tmp_path / "r.urdf").write_text(
        parallel().urdf.replace("</robot>", f"{gear}</transmission></robot>")
    )
    answer = crosscheck("cost", tmp_path / "r.urdf")
    assert (answer.code, answer.out) == (2, "")
    assert "shoulder: without a ratio and a rotor inertia" in answer.err
    assert "elbow: without a rotor inertia" in answer.err
    file = load_as_robot(str(tmp_path / "r.urdf"), 9.0, 1e-4)
    assert {file.joints[each.joint].name: each.ratio for each in file.rotors} == {
        "shoulder": 9.0,
        "elbow": 50.0,
    }
    assert "each has a rotor" in crosscheck("cost", "puma560", "--ratio", 4).err
    for number in (0, "nan"):
        assert ": --ratio = " in crosscheck("cost", tmp_path / "r.urdf", "--ratio", number).err
    assert "add --rotor-inertia 1e-4\n" in crosscheck("cost", tmp_path / "r.urdf", "--ratio", 9).err


def test_numbers_that_an_arm_lacks_belong_in_its_own_file(tmp_path):
    (tmp_path / "plain.toml").write_text(template(make_plain_arm("plain", 2)), encoding="utf-8")
    with pytest.raises(InputError, match="they belong in the arm's file; for a first answer add"):
        load_as_robot(str(tmp_path / "plain.toml"))


def test_engines_that_differ_are_reported_and_fail_the_command(monkeypatch, crosscheck):
    monkeypatch.setattr(tasks, "build_robot_model", chains.build_wrong_exudyn)
    answer = crosscheck("cost", "sliding", "--quick")
    assert answer.code == 1
    assert "engines differ: gravity of coupled: analytic and exudyn by" in answer.out
    assert answer.out.startswith("The programs do not agree on sliding, so no cost is given.")
    lost = SimpleNamespace(verdict="failed", measured=None, note="exudyn:links: died")
    both: Any = SimpleNamespace(agreement=[lost, lost], robot=SimpleNamespace(name="sliding"))
    assert list(_describe_disagreements(both))[1:] == ["engines: exudyn:links: died"]


def test_the_command_writes_json_and_a_page(crosscheck, tmp_path):
    """And again over its own files: the same seed gives the same numbers."""
    files = ["--json", tmp_path / "cost.json", "--out", tmp_path]
    contents = set()
    for _ in range(2):
        answer = crosscheck("cost", "sliding", "--quick", "--seed", 4, *files)
        assert (answer.code, answer.err) == (0, "")
        contents.add((tmp_path / "cost.json").read_bytes())
    assert len(contents) == 1
    assert is_file_of_type(tmp_path / "cost.json", file_types.COST)
    assert is_file_of_type(tmp_path / "cost.html", file_types.COST_PAGE)
    assert json.loads(contents.pop())["geared"]["distances_m"] is None
    assert "No run of the level geared" in answer.out


@pytest.mark.parametrize(
    ("limits", "expected"),
    [
        ((-1.0, 2.0), (-1.0, 2.0)),
        ((-10.0, 10.0), (-np.pi, np.pi)),
        ((-np.inf, np.inf), (-np.pi, np.pi)),
        ((5.0, np.inf), (5.0, 5.0 + 2 * np.pi)),
        ((-np.inf, -4.0), (-4.0 - 2 * np.pi, -4.0)),
        ((-1.0, np.inf), (-1.0, 2 * np.pi - 1.0)),
    ],
)
def test_motions_stay_within_limits_of_which_one_may_be_missing(limits, expected):
    own = parallel()
    first = own.joints[0]
    limited = replace(first.limits, lower=limits[0], upper=limits[1])
    own = replace(own, joints=(replace(first, limits=limited), *own.joints[1:]))
    assert motion_range(own, 0) == pytest.approx(expected)


def test_one_quantity_that_differs_is_marked_at_its_level_alone():
    costs = found_cost("oblique", engines=True)
    first, *others = costs.agreement
    assert first.verdict == "agree"
    shown = replace(costs, agreement=(replace(first, verdict="differ"), *others))
    cells = [cell for row in _tabulate_agreement(shown) for cell in row.cells]
    assert sum(cell.endswith("differs") for cell in cells) == 1
