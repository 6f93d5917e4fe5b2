"""What a comparison with records says: key words and numbers of made answers."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, get_args

import numpy as np
import pytest

from crosscheck.identification import compare, messages, output
from crosscheck.identification.bandwidth import BandResult, combine_bands
from crosscheck.identification.mechanism import PlanarArm, SpatialRobot
from crosscheck.identification.restrictions import FileJudgement, Restriction, flag_friction
from crosscheck.identification.terms import TermEstimate, TermKind, TorqueTerm
from crosscheck.models.loading import load_arm
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.planar import build_planar_robot
from crosscheck.models.robot.urdf import UrdfLink
from tests.loops import require_items
from tests.measured.robots import arm


def made(**fields: Any) -> Any:
    return SimpleNamespace(**fields)


def estimate(kind: Any, joint: str, value: float = 0.354) -> TermEstimate:
    """0.354 with a 95 % interval of 0.0042."""
    return TermEstimate(TorqueTerm(kind, f"{kind} of {joint}", "kg m^2"), value, 0.0021, 0.0042)


J1, J2, J3 = (estimate("armature", name) for name in ("j1", "j2", "j3"))
TEXT = "armature of j3 0.3540 +- 0.0042 kg m^2"
DELAY = TermEstimate(TorqueTerm("delay", "delay", "s"), 1.5e-3, 1e-4, 2e-4)


def side(**changes: Any) -> Any:
    plain = {
        "side": "motor",
        "links": "identified",
        "is_excited": True,
        "impossible": (),
        "seen": (),
        "rotors": (),
        "delay": None,
        "contained": (),
        "excitation": None,
        "judgement": None,
        "measured": ("j1", "j2"),
        "unexplained": np.array([0.004, 0.0123]),
        "threshold": 4.0,
    }
    return made(**plain | changes)


def poor(names: str, condition: float, suggested: Any = None) -> Any:
    return side(is_excited=False, concerned=tuple(names), condition=condition, excitation=suggested)


def suggest(seed: int, period: float, condition: float) -> Any:
    return made(motion=made(seed=seed, period=period), condition=condition)


SIDES: dict[str, tuple[Any, list[str]]] = {
    "nothing": (side(), ["alone explain the torques of the motors: all but 1.2 % at j2 (rms)."]),
    "much that nothing explains": (
        side(unexplained=np.array([0.004, 0.82])),
        ["leave 82 % of the torques of the motors unexplained at j2 (rms)."],
    ),
    "a rotor and others": (
        side(seen=(J3,), rotors=(J1, J2, J3)),
        [
            f"do not explain the torques of the motors: {TEXT}.",
            "Too uncertain to be named: armature of j1",
        ],
    ),
    "a rotor behind gears": (
        side(side="joint", seen=(J3, J2), rotors=(J3, J2)),
        ["do not explain the torques behind the gears", "(motor_torque)?"],
    ),
    "what no rotor has": (
        side(impossible=(J3,), seen=(J2,), rotors=(J2, J3)),
        [f"{TEXT}, which no rotor can have"],
    ),
    "a lag": (side(delay=DELAY), ["alone explain", "lag behind the motion: delay 0.00150 +- 0.00"]),
    "the other way round": (
        side(delay=TermEstimate(DELAY.term, -1.5e-3, 1e-4, 2e-4)),
        ["alone explain", "come before the motion: delay -0.00150"],
    ),
    "what links make up": (
        side(contained=(J1.term, TorqueTerm("offset", "offset of j2", "N m"), J2.term)),
        ["alone explain", "from the links: armature of j1, armature of j2."],
    ),
    "a motion that shows little": (
        poor("abcdefgh", 1234.5, suggest(17, 6.2832, 45.67)),
        ["a, b, c, d, e, f (condition number 1234, at most 1000)", "17, period 6.28 s) has a con"],
    ),
    "a motion of which none shows more": (
        poor("a", 1001.0, suggest(3, 2.0, 2345.6)),
        ["hardly shows a (condition number 1001", "2.3e+03: none"],
    ),
    "limits that read differently": (poor("m", 1000.4), ["1000.4, at most 1000"]),
}


@pytest.mark.parametrize("name", SIDES)
def test_a_side_says(name):
    given, words = SIDES[name]
    lines = list(messages._describe_side(given))
    assert len(lines) == len(words)
    assert all(part in line for line, part in zip(lines, words, strict=True))


def test_every_kind_of_term_is_estimated_in_one_step_or_with_links():
    """But for those of a refinement."""
    steps = [kind for _, kinds in compare.STEPS for kind in kinds]
    steps += [kind for kinds in compare.LINK_KINDS.values() for kind in kinds]
    assert sorted([*steps, "rotors", "gain", "zero", "number"]) == sorted(get_args(TermKind))


@pytest.mark.parametrize(("share", "is_body"), [(0.98, False), (1.02, True)])
def test_of_a_frame_next_to_no_mass_there_is_the_mass_alone(share, is_body):
    robot = load_robot("puma560")
    mass = share * 1e-6 * max(body.mass for body in robot.bodies)
    frame = UrdfLink("frame", replace(robot.bodies[0], mass=mass))
    numbers = SpatialRobot(robot, {"frame": frame}).parameters
    of_frame = [each.path for each in numbers if each.path.startswith("robot.links.frame")]
    assert (of_frame[0], len(of_frame) > 1) == ("robot.links.frame.mass_kg", is_body)


def test_json_has_what_links_with_a_prior_are():
    bodies = made(excess=1.5, explain=True, impossible=("a",), border=("b",))
    fit = made(level="links", chi_squared=2.0, surprise=3.0, settled=True, contained=("c",))
    refinement = made(
        knowledge=made(links=0.1, unknown=("y", "x"), are_possible=True),
        level="coupled",
        is_surprising=False,
        fits=[fit],
    )
    fit.bodies, fit.estimates = bodies, ()
    content: Any = output._refinement_content(made(refinement=refinement))
    levels = content.pop("levels")
    assert [*content.values()] == [0.1, ["x", "y"], True, "coupled", False]
    assert [*levels[0].pop("possible_bodies").values()] == [1.5, True, ("a",), ("b",)]
    assert [*levels[0].values()] == ["links", 2.0, 3.0, True, ("c",), []]


FACTOR = TermEstimate(TorqueTerm("scale", "link b", "1", 1.0), 1.25, 0.01, 0.02)


def test_links_of_the_file_say_how_far_off_they_are():
    scaled, free = made(side="between", wrong_factors=(FACTOR,), rotors=(J3,)), side()
    scaled.find_worse_joints = lambda identified: {"j2": 1.2345, "j3": 2.0}
    _, factor, worse = messages._describe_scaled(scaled, free)
    assert f"1.250 +- 0.020 for {FACTOR.term.name}" in factor
    assert "1.23 at j2, 2.00 at j3" in worse
    free.is_excited, scaled.wrong_factors = False, ()
    (line,) = messages._describe_scaled(scaled, free)
    assert TEXT in line


def test_an_estimate_that_another_band_moves_has_no_interval():
    apart = replace(FACTOR, doubled=1.5)
    assert "(depends on the band: 1.500 1 in twice the band)" in messages.format_estimate(apart)
    for there, is_flagged in ((1.275, True), (1.265, False)):
        wide = BandResult(2.0, (replace(FACTOR, value=there),))
        (flagged,) = combine_bands([FACTOR], 1.0, [wide])
        assert (flagged.doubled == there) is is_flagged
    noisy = BandResult(2.0, (replace(FACTOR, value=1.275, half_width=0.03),))
    assert combine_bands([FACTOR], 1.0, [noisy]) == (FACTOR,)


def test_the_part_of_an_error_that_other_bands_make_stands_beside_its_estimate():
    apart = TermEstimate(FACTOR.term, 1.25, 0.01, 0.02, systematic=0.006)
    given = side(
        bandwidth=4.0,
        samples=made(step=0.0123),
        condition=56.7,
        blocks=20,
        steps=(),
        estimates=(FACTOR, apart),
        bands=(made(bandwidth=2.0, estimates=(FACTOR,)), made(bandwidth=8.0, estimates=())),
    )
    head, first, second, *bands = output._describe_side(given, is_brief=False, unit="N m")
    assert "up to 4 Hz by rows 12.3 ms apart, condition number 56.7" in head
    assert second == f"{first}, 60% of its error from other bands"
    assert bands == ["  up to 2 Hz: link b 1.250 +- 0.020 1", "  up to 8 Hz: nothing to estimate"]


def prior(level: str | None = "coupled", **changes: Any) -> Any:
    armature = made(level="armature", chi_squared=123.456)
    best = made(
        level="coupled", chi_squared=23.4567, estimates=(J3, FACTOR), surprise=98.765, shown=12
    )
    plain = {"is_surprising": False, "is_impossible": False, "fits": (armature, best)}
    return made(**plain | {"best": best, "level": level} | changes)


SIZES = "123.46 for armature and 23.457 for coupled"
PRIORS = {
    f"are those of coupled (chi squared {SIZES}): {TEXT}": prior(),
    f"armature and coupled cannot be distinguished (chi squared {SIZES})": prior(None),
    "further from the file than that (chi squared 98.77 of 12": prior(is_surprising=True),
    "no level has possible bodies that explain the torques": prior(is_impossible=True),
    f"{TEXT}. The file has no rotors": prior(fits=(1,)),
}


@pytest.mark.parametrize("text", PRIORS)
def test_links_known_to_a_share_say_which_level_it_is(text):
    line = messages._describe_prior(PRIORS[text], 0.055)
    assert line.startswith("With the file's links known to 5.5 %")
    assert text in line


def test_possible_bodies_and_others():
    def bodies(explain: bool, *border: str) -> Any:
        return made(explain=explain, border=border, impossible=("a", "b"), excess=1234.56)

    described = messages._describe_bodies
    assert "as well as any." in described("coupled", bodies(True))
    assert "moved by j1, j2 are at the border" in described("coupled", bodies(True, "j1", "j2"))
    none = described("coupled", bodies(False, "j1", "j2"))
    assert "a, b would be impossible (possible ones have 1235 more" in none


def test_levels_that_are_one_model_are_said_to_be():
    def levels(slides: tuple[int, ...] = (), **ranks: Any) -> str:
        mechanism = made(robot=made(slides=slides))
        return " ".join(messages._describe_levels(made(ranks=made(**ranks), mechanism=mechanism)))

    assert "if stators are on the links before" in levels(are_equal=True, assumed=True)
    assert "same model with other links. No" in levels(are_equal=True, assumed=False)
    other = levels(are_equal=False, coupled=30, armature=31, both=33)
    assert "ranks 30, 31, together 33): a stator is not" in other
    other = levels((2,), are_equal=False, coupled=30, armature=31, both=33)
    assert "together 33): a joint slides, a stator" in other


INTERVALS = {
    "12.3 +- 1.5": (12.34, 1.46),
    "1234 +- 145": (1234.4, 145.2),
    "0.00123 +- 0.00012": (0.0012345, 0.000123),
    "1.23 +- inf": (1.2345, np.inf),
    "1.23 +- 0": (1.2345, 0.0),
}


@pytest.mark.parametrize("text", INTERVALS)
def test_a_value_has_the_digits_of_its_interval(text):
    value, half_width = INTERVALS[text]
    assert messages._format_interval(TermEstimate(FACTOR.term, value, 1.0, half_width)) == text
    assert messages.format_row([1.23456, -2000.0]) == "1.23, -2e+03"


def test_numbers_are_as_short_as_their_intervals_allow():
    value, number = messages.format_value, messages.format_number
    assert [value(1.23456, 0.1, 1.0), value(1.23456, 1e-4, 1.2345)] == ["1.23", "1.2346"]
    assert value(1.23456, 1e-9, 1.2) == "1.2346"  # of its change, 0.035, 1 % is lost at most
    assert [number(999.4), number(1234.5), number(1e7), number(0.01234)] == [
        *("999", "1,234", "1e+07", "0.0123")
    ]
    assert [messages._format_ratio(each) for each in (12.3, 2e12)] == ["12", "over 1e+12"]
    assert messages.format_distinct([1234567.1, 1234567.2], 5) == ["1234567.1", "1234567.2"]
    assert messages.format_distinct([2.0, 2.0]) == ["2", "2"]
    for exact in (10.0, 1234567.8, 0.1 + 0.2):
        assert float(messages.format_exact(exact)) == exact


PHRASES = {
    "arm.payload_mass_kg": ("kg", "the payload"),
    "arm.links.1.density_kg_per_m3": ("kg/m^3", "the density of link 2"),
    "arm.joints.0.friction_N_m_s_per_rad": ("N m s/rad", "the viscous friction of joint 1"),
    "arm.joints.1.planet_mass_kg": ("kg", "the planet mass of joint 2"),
    "robot.links.a.mass_kg": ("kg", "the mass of a"),
    "robot.links.c.com_m.z": ("m", "the centre of mass of c along z"),
    "robot.links.b.inertia_kg_m2.xy": ("kg m^2", "the inertia Ixy of b"),
    "robot.joints.j2.rotor_inertia_kg_m2": ("kg m^2", "the rotor inertia of j2"),
    "robot.joints.joint_1.sun_equivalent_mass_kg": ("kg", "the sun equivalent mass of joint_1"),
}


@pytest.mark.parametrize("path", PHRASES)
def test_a_number_of_a_file_is_called_what_people_call_it(path):
    mechanisms = (
        PlanarArm(load_arm("paper-labelled")),
        SpatialRobot(arm()),
        SpatialRobot(build_planar_robot(load_arm("paper-labelled"))),
    )
    every = [each for mechanism in mechanisms for each in mechanism.parameters]
    parameter = next(each for each in every if each.path == path)
    assert (parameter.unit, parameter.phrase) == PHRASES[path]


UNITS_BY_ENDING = {
    "mass_kg": "kg",
    "inertia_kg_m2": "kg m^2",
    "com_m": "m",
    "density_kg_per_m3": "kg/m^3",
    "friction_N_m_s_per_rad": "N m s/rad",
    "ratio": "",
    "armature": "kg m^2",
}


def test_the_unit_of_a_number_is_the_one_that_its_field_ends_in():
    arms = [load_arm(name) for name in ("paper-labelled", "direct-between", "three-unlike")]
    robots = [arm(), load_robot("examples/robots/planetary-arm.toml")]
    own = map(SpatialRobot, (*robots, *map(build_planar_robot, arms)))
    every = [each for one in (*map(PlanarArm, arms), *own) for each in one.parameters]
    for parameter in require_items(every):
        fields = [part for part in parameter.path.split(".") if len(part) > 2]
        (unit,) = {unit for ending, unit in UNITS_BY_ENDING.items() if fields[-1].endswith(ending)}
        assert parameter.unit == unit, parameter.path


LABELLED = PlanarArm(load_arm("paper-labelled"))
PAYLOAD = next(each for each in LABELLED.parameters if each.path == "arm.payload_mass_kg")


def restriction(
    level: str, *, value: float | None = None, surprise: float = 0.0, chance: float = 0.5
) -> Restriction:
    """A level, or one with another payload [kg], which no file may hold if it is negative."""
    term = TorqueTerm("number", PAYLOAD.phrase, "kg", PAYLOAD.value)
    number = () if value is None else (TermEstimate(term, value, 0.005, 0.01),)
    mechanism = LABELLED if value is None or value > 0 else None
    changed = None if value is None else PAYLOAD
    ratios = np.array([1.5, 1.25])
    return Restriction(level, changed, number, ratios, chance, surprise, mechanism)


def judge(*levels: Restriction, changes: tuple[Restriction, ...] = ()) -> list[str]:
    judgement = FileJudgement(levels, changes)
    return list(messages._describe_judgement(LABELLED, side(judgement=judgement), judgement))


BEST, NEXT = restriction("coupled"), restriction("armature", surprise=2 * np.log(1e4), chance=0.0)
HEAVIER = restriction("coupled", value=10.2)
MOVED = replace(HEAVIER, estimates=(replace(HEAVIER.estimates[0], doubled=10.6),))
WRONG = restriction("coupled", surprise=2 * np.log(101.0), chance=0.0)
VERDICTS: dict[str, tuple[list[str], list[str]]] = {
    "decided": (
        judge(BEST, NEXT),
        [
            "fits rigid gears (coupled) with the file's numbers.",
            "armature, the next best, is 1e+04",
        ],
    ),
    "two levels": (judge(BEST, restriction("armature")), ["coupled and armature with the file"]),
    "one change": (
        judge(WRONG, changes=(HEAVIER,)),
        ["coupled) if the payload is 10.2 kg; the file says 10.", "nearest, rigid gears (coupled)"],
    ),
    "one of another band": (
        judge(WRONG, changes=(MOVED,)),
        ["10.200 kg (depends on the band: 10.600 kg in twice the band); the file", "nearest"],
    ),
    "two changes": (
        judge(WRONG, changes=(HEAVIER, restriction("links", value=9.9))),
        ["the payload is 10.2 kg", "cannot distinguish", "(links) if the payload is 9.9", "1.5"],
    ),
    "nothing": (
        judge(WRONG, changes=(restriction("coupled", value=10.2, chance=1e-3),)),
        ["no single number", "is 1.5 times that", "change of a number: rigid gears (coupled) if"],
    ),
    "impossible": (
        judge(WRONG, changes=(restriction("coupled", value=-1.0),)),
        [
            "no single number",
            "1.5 times",
            "the payload would have to be -1 kg, which is impossible",
        ],
    ),
}


def test_a_change_that_explains_nothing_may_be_the_likeliest():
    better = restriction("coupled", value=10.2, chance=1e-3)
    judgement = FileJudgement((WRONG,), (better,))
    assert judgement.best is WRONG
    assert judgement.likeliest is better
    assert judgement.compare(WRONG, judgement.likeliest) == pytest.approx(101.0)


@pytest.mark.parametrize("name", VERDICTS)
def test_a_verdict_says(name):
    lines, words = VERDICTS[name]
    assert len(lines) == len(words)
    assert all(part in line for line, part in zip(lines, words, strict=True))


def test_friction_is_flagged_where_it_is_not_the_files():
    robot = load_robot("sliding")
    joint, own = robot.coordinate_names[0], float(robot.friction[0])
    terms = [TorqueTerm(kind, f"{kind} of {joint}", "") for kind in ("viscous", "coulomb")]
    values = (own + 0.41, own + 0.39), (0.41, 0.39)
    for term, (more, less) in require_items(zip(terms, values, strict=True)):
        for value, is_flagged in ((more, True), (less, False)):
            rubs = replace(BEST, estimates=(TermEstimate(term, value, 0.1, 0.2),))
            assert bool(flag_friction(rubs, robot, 4.0)) is is_flagged


def test_runs_say_whether_they_stay():
    for stays, word in ((0.3, "leaves"), (2.0, "stays")):
        window = made(stays_s=stays, time=[1.0, 3.0], within=1.0)
        (line,) = messages._describe_runs(made(windows=[window]))
        assert f"1 recorded state, it {word}" in line
        assert "median" not in line
    assert list(messages._describe_runs(made(windows=[]))) == []
