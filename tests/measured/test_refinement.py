"""Links known by their file, gains of drives and encoders' zeros, against identities and truth."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from crosscheck.identification.compare import compare
from crosscheck.identification.description import RecordDescription, find_knowledge
from crosscheck.identification.mechanism import SpatialRobot
from crosscheck.identification.refinement import Knowledge
from crosscheck.models.robot.robot import Robot
from tests.loops import require_items
from tests.measured.robots import RATIO, ROTOR, SOLIDS, arm, recording
from tests.measured.second_refinement import refine_again
from tests.measured.unknowns import SECONDS, TIMES, ask, estimate_unknowns, refine_alone
from tests.robots import chains


@pytest.fixture(scope="module")
def robot() -> Robot:
    return arm()


@pytest.mark.parametrize("level", ["armature", "coupled"])
def test_links_known_to_less_than_the_identity_moves_decide(robot, level):
    """J N is 0.006 kg m^2, some 2 % of the links' moments."""
    given = recording(robot, level, seconds=SECONDS)
    tight = ask(robot, given, Knowledge(0.002))
    found = tight.sides[0].refinement
    assert found.level == level
    assert tight.is_decided
    for each in found.best.estimates:
        if each.term.kind in ("armature", "rotors"):
            assert abs(each.value - RATIO**2 * ROTOR) < 1.5 * each.half_width
    loose = refine_alone(robot, given, Knowledge(0.2))[1]
    assert (loose.level, loose.is_decided) == (None, False)


def test_links_that_are_not_as_known_name_no_level(robot):
    heavier = arm(robot.urdf.replace('mass value="5.0"', 'mass value="5.5"'))
    given = recording(robot, "coupled", seconds=SECONDS)
    found = refine_alone(heavier, given, Knowledge(0.002))[1]
    assert found.is_surprising
    assert found.level is None
    assert not found.is_decided


@pytest.mark.parametrize(
    ("level", "knowledge"),
    [
        ("armature", Knowledge(0.01)),
        ("coupled", Knowledge(0.01)),
        ("armature", Knowledge(0.05, frozenset({"gains", "zeros"}))),
        ("armature", Knowledge(None, frozenset({"zeros"}))),
    ],
)
def test_a_second_program_refines_the_same(robot, level, knowledge):
    """1e-8 of standard errors or values: slopes in positions differ by their steps, 1e-10."""
    given = recording(robot, level, seconds=SECONDS)
    stated = robot if level == "coupled" else replace(robot, rotors=())
    bandwidth, found = refine_alone(stated, given, knowledge)
    (fit,) = (each for each in found.fits if each.level == level)
    own = {each.term.name: (each.value, each.error) for each in fit.estimates}
    ratios = [RATIO] * 3 if level == "coupled" else None
    second = refine_again(robot.urdf, given, bandwidth, knowledge, ratios)
    assert set(own) == set(second)
    for name, (value, error) in own.items():
        other, spread = second[name]
        assert abs(value - other) < 1e-8 * max(abs(value), error)
        assert spread == pytest.approx(error, rel=1e-6)


def test_gains_and_zeros_are_found():
    """Twice the 95 % intervals hold what is true, but for one of 15,000.

    How often the intervals do is counted by benchmarks/bench_measured.py.
    """
    for each, value in require_items(estimate_unknowns(seed=0)):
        assert abs(each.value - value) < 2 * each.half_width
        assert each.half_width < 0.1


def test_zeros_that_links_make_up_are_not_distinguished(robot):
    """An encoder before all links, or at the last: a body that stands otherwise is the same."""
    given = recording(robot, "armature", seconds=SECONDS)
    given = replace(given, position=given.position - np.array([0.0, 0.03, 0.0]))
    found = refine_alone(robot, given, Knowledge(None, frozenset({"zeros"})))[1]
    assert found.best.contained == ("j1", "j3")
    (zero,) = (each for each in found.best.estimates if each.term.kind == "zero")
    assert abs(zero.value - 0.03) < 1.5 * zero.half_width
    assert zero.half_width < 0.03


HELD, PLACE = 1.5, (0.25, 0.1, 0.05)  # [kg] of a payload, and where in the frame of link c [m]


def test_a_known_payload_tells_the_gains(robot):
    """Bare and loaded: the difference has a known size, though no link of the file is believed."""
    payload = pin.Inertia(HELD, np.array(PLACE), np.zeros((3, 3)))
    links = pin.buildModelFromXML(robot.urdf).inertias
    whole = links[3] + payload
    upper = whole.inertia[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    solid = chains.Solid(float(whole.mass), whole.lever.tolist(), upper.tolist())
    loaded = arm(solids=(*SOLIDS[:2], solid))
    bare, full = (
        recording(each, "armature", seed, seconds=SECONDS, gain=TIMES)
        for seed, each in ((3, robot), (4, loaded))
    )
    held = np.concatenate([np.zeros(20), payload.toDynamicParameters()])
    knowledge = Knowledge(None, frozenset({"gains"}), payloads=(0 * held, held))
    wrong = arm(solids=[each._replace(mass=3 * each.mass) for each in SOLIDS])
    asked = SpatialRobot(wrong), [bare, full], np.eye(3), lambda *_: None, knowledge
    side = compare(*asked).sides[0]
    gains = [each for each in side.refinement.best.estimates if each.term.kind == "gain"]
    assert len(gains) == 3
    for each in gains:
        assert abs(each.value - 1 / TIMES) < 1.5 * each.half_width
        assert each.half_width < 0.05


def test_a_payload_on_a_fixed_link_is_part_of_the_body_that_carries_it(robot):
    """In the frame of the joint, as Pinocchio moves an inertia."""
    tool = chains.link("tool") + chains.joint(
        "held", "c", "tool", "fixed", at=(0.3, -0.1, 0.2), rpy=(0.4, 0.5, -0.6), more=" "
    )
    robot = chains.robot(robot.urdf.replace("</robot>", f"{tool}</robot>"))
    files = {"position": "r.csv", "payload": {"link": "tool", "mass_kg": HELD, "place_m": PLACE}}
    stated = {"schema_version": 1, "recordings": [files], "position": {"columns": ["a"]}}
    found = find_knowledge(RecordDescription.model_validate(stated), robot, Path("r.toml"))
    model = pin.buildModelFromXML(robot.urdf)
    place = model.frames[model.getFrameId("tool")].placement
    right = place.act(pin.Inertia(HELD, np.array(PLACE), np.zeros((3, 3))))
    assert found.payloads[0][:20] == pytest.approx(0.0)
    assert found.payloads[0][20:] == pytest.approx(right.toDynamicParameters())


@pytest.mark.parametrize(
    ("more", "knowledge"),
    [
        ({}, Knowledge()),
        ({"estimate": ["gains", "zeros"]}, Knowledge(unknown=frozenset({"gains", "zeros"}))),
        ({"prior": {"links": 0.05}}, Knowledge(0.05)),
        ({"prior": {"links": 0.5, "bodies": "possible"}}, Knowledge(0.5, are_possible=True)),
    ],
)
def test_a_description_says_what_is_known(robot, more, knowledge):
    stated = {"schema_version": 1, "recordings": [{"position": "r.csv"}], **more}
    description = RecordDescription.model_validate(stated | {"position": {"columns": ["a"]}})
    assert find_knowledge(description, robot, Path("r.toml")) == knowledge
