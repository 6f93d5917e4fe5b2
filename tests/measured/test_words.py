"""What a comparison with records says of made answers."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, get_args

import numpy as np
import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.cli.files.template import make_plain_arm
from crosscheck.identification import compare, messages, output
from crosscheck.identification.bandwidth import BandResult, combine_bands
from crosscheck.identification.mechanism import PlanarArm, SpatialRobot
from crosscheck.identification.refinement import Knowledge
from crosscheck.identification.restrictions import FileJudgement, Restriction, _apply, flag_friction
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
    fit = made(condition=condition)
    return side(is_excited=False, concerned=tuple(names), fit=fit, excitation=suggested)


def suggest(seed: int, period: float, condition: float) -> Any:
    return made(motion=made(seed=seed, period=period), condition=condition)


OFFSET = TorqueTerm("offset", "offset of j2", "N m")
SIDES: dict[str, Any] = {
    "nothing": side(),
    "much that nothing explains": side(unexplained=np.array([0.004, 1.08])),
    "a rotor and others": side(seen=(J3,), rotors=(J1, J2, J3)),
    "a rotor behind gears": side(side="joint", seen=(J3, J2), rotors=(J3, J2)),
    "what no rotor has": side(impossible=(J3,), seen=(J2,), rotors=(J2, J3)),
    "a lag": side(delay=DELAY),
    "the other way round": side(delay=TermEstimate(DELAY.term, -1.5e-3, 1e-4, 2e-4)),
    "what links make up": side(contained=(J1.term, OFFSET, J2.term)),
    "a motion that shows little": poor("abcdefgh", 1234.5, suggest(17, 6.2832, 45.67)),
    "a motion of which none shows more": poor("a", 1001.0, suggest(3, 2.0, 2345.6)),
    "limits that read differently": poor("m", 1000.4),
}


@pytest.mark.parametrize("name", SIDES)
def test_a_side_says(name: str, snapshot: SnapshotAssertion):
    assert "\n".join(messages._describe_side(SIDES[name])) == snapshot


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


@pytest.mark.parametrize("excited", [True, False])
def test_links_of_the_file_say_how_far_off_they_are(excited: bool, snapshot: SnapshotAssertion):
    factors = (FACTOR,) if excited else ()
    scaled = made(side="between", wrong_factors=factors, rotors=(J3,))
    scaled.find_worse_joints = lambda identified: {"j2": 1.2345, "j3": 2.0}
    lines = messages._describe_scaled(scaled, side(is_excited=excited))
    assert "\n".join(lines) == snapshot
    shown = made(select=lambda kind: [J1], threshold=4.0, is_excited=excited)
    assert vars(compare.SideResult)["has_other_gravity"].fget(shown) == excited
    bare = messages._describe_scaled(scaled, side(is_excited=excited), has_gears=False)
    assert not [line for line in bare if "rotor" in line or "armature" in line]


def test_an_arm_without_gears_has_no_rotors_to_distinguish():
    lines = [*messages._describe_side(SIDES["a motion that shows little"], has_gears=False)]
    assert lines[0].startswith("The motion hardly shows a, b, c, ")
    assert not messages._has_gears(PlanarArm(make_plain_arm("plain", 2)))
    assert messages._has_gears(LABELLED)


@pytest.mark.parametrize("way", [1, -1])
def test_what_is_off_either_way_is_named(way):
    late, off = replace(DELAY, value=way * DELAY.value), replace(FACTOR, value=1 + way / 4)
    shown = made(select=lambda kind: [late if kind == "delay" else off], threshold=4.0)
    assert vars(compare.SideResult)["delay"].fget(shown) == late
    assert vars(compare.SideResult)["wrong_factors"].fget(shown) == (off,)


def test_gains_are_decided_by_links_or_a_payload_which_no_file_has():
    sides = [side(refinement=None), side(refinement=None, links="scaled", is_excited=False)]
    held = np.zeros(10), np.ones(10)  # nothing, and a payload
    for links, payloads, is_decided in ((0.1, (), True), (None, (), False), (None, held, True)):
        knowledge = Knowledge(links, frozenset({"gains"}), payloads=payloads)
        compared = made(knowledge=knowledge, sides=sides)
        assert vars(compare.RecordComparison)["is_decided"].fget(compared) is is_decided
    assert not list(compare._run_best(made(knowledge=knowledge, judged_sides=[None])))


@pytest.mark.parametrize(
    ("factor", "step", "suspected"),
    [
        *[(0.09, 0.01, "links"), (-1.0, 0.01, ""), (11.0, 0.01, "links")],
        *[(1.0, 1.0, "in milliseconds"), (1.0, 1e-6, "in seconds")],
    ],
)
def test_units_are_suspected_and_nothing_else_concluded(factor, step, suspected):
    sides = (side(wrong_factors=()), side(wrong_factors=(replace(FACTOR, value=factor),)))
    doubtful = made(sides=sides, records=[made(step=step)], engines_agree=True)
    doubtful.is_fitting = False
    said = messages.suspect_units(doubtful)
    assert suspected in said
    assert bool(suspected) == bool(said)
    assert not said or (messages.describe_answers(doubtful), output._select_sides(doubtful)) == (
        [said],
        (),
    )


def test_an_estimate_that_another_band_moves_has_no_interval(snapshot: SnapshotAssertion):
    apart = replace(FACTOR, doubled=1.5)
    assert messages.format_estimate(apart) == snapshot
    for there, is_flagged in ((1.275, True), (1.265, False)):
        wide = BandResult(2.0, (replace(FACTOR, value=there),))
        (flagged,) = combine_bands([FACTOR], 1.0, [wide])
        assert (flagged.doubled == there) is is_flagged
    noisy = BandResult(2.0, (replace(FACTOR, value=1.275, half_width=0.03),))
    assert combine_bands([FACTOR], 1.0, [noisy]) == (FACTOR,)


@pytest.mark.parametrize(("doubled", "is_tilt"), [(None, True), (1.5, False)])
def test_gravity_that_another_band_moves_is_no_tilt(doubled, is_tilt):
    term = TorqueTerm("gravity", "gravity along x beyond the file's", "m/s^2", 0.0)
    leaning = TermEstimate(term, 1.0, 0.005, 0.01, doubled=doubled)
    weighed = made(select=lambda kind: [leaning], find_worse_joints=lambda other: {})
    assert bool(compare._find_tilt(arm(), weighed, made())) == is_tilt


def test_an_error_that_other_bands_make_stands_beside_its_estimate(snapshot: SnapshotAssertion):
    apart = TermEstimate(FACTOR.term, 1.25, 0.01, 0.02, systematic=0.006)
    given = side(
        bandwidth=4.0,
        samples=made(step=0.0123),
        fit=made(condition=56.7, blocks=20),
        steps=(),
        estimates=(FACTOR, apart),
        bands=(made(bandwidth=2.0, estimates=(FACTOR,)), made(bandwidth=8.0, estimates=())),
    )
    assert "\n".join(output._describe_side(given, is_brief=False, unit="N m")) == snapshot


def prior(level: str | None = "coupled", **changes: Any) -> Any:
    armature = made(level="armature", chi_squared=123.456)
    best = made(
        level="coupled", chi_squared=23.4567, estimates=(J3, FACTOR), surprise=98.765, shown=12
    )
    plain = {"is_surprising": False, "is_impossible": False, "fits": (armature, best)}
    return made(**plain | {"best": best, "level": level} | changes)


PRIORS = {
    "a level": prior(),
    "no level": prior(None),
    "links that are surprising": prior(is_surprising=True),
    "no possible bodies": prior(is_impossible=True),
    "no rotors": prior(fits=(1,)),
}


@pytest.mark.parametrize("name", PRIORS)
def test_links_known_to_a_share_say_which_level_it_is(name: str, snapshot: SnapshotAssertion):
    assert messages._describe_prior(PRIORS[name], 0.055) == snapshot


@pytest.mark.parametrize(
    ("explain", "border"), [(True, ()), (True, ("j1", "j2")), (False, ("j1", "j2"))]
)
def test_possible_bodies_and_others(explain, border, snapshot: SnapshotAssertion):
    bodies = made(explain=explain, border=border, impossible=("a", "b"), excess=1234.56)
    assert messages._describe_bodies("coupled", bodies) == snapshot


UNEQUAL = {"are_equal": False, "coupled": 30, "armature": 31, "both": 33}
RANKS = {
    "equal by assumption": ((), {"are_equal": True, "assumed": True}),
    "equal": ((), {"are_equal": True, "assumed": False}),
    "another stator": ((), UNEQUAL),
    "a slide": ((2,), UNEQUAL),
}


@pytest.mark.parametrize("name", RANKS)
def test_levels_that_are_one_model_are_said_to_be(name: str, snapshot: SnapshotAssertion):
    slides, ranks = RANKS[name]
    compared = made(ranks=made(**ranks), mechanism=made(robot=made(slides=slides)))
    assert "\n".join(messages._describe_levels(compared)) == snapshot


INTERVALS = {
    "12.3 ± 1.5": (12.34, 1.46),
    "1234 ± 145": (1234.4, 145.2),
    "0.00123 ± 0.00012": (0.0012345, 0.000123),
    "1.23 ± inf (the record does not determine it)": (1.2345, np.inf),
    "1.2345 ± 0": (1.2345, 0.0),
    "1.30005 ± 1e-11": (1.30005, 1e-11),
    "6e-07 ± 1.2e-06": (6e-7, 1.2e-6),
    "0.4512345 ± 0.0000012": (0.4512345, 1.2e-6),
    "1 ± 41 (the record does not determine it)": (1.2, 41.0),
    "-1.2 ± 1.1": (-1.2, 1.1),
}


@pytest.mark.parametrize("text", INTERVALS)
def test_a_value_has_the_digits_of_its_interval(text):
    value, half_width = INTERVALS[text]
    assert messages._format_interval(TermEstimate(FACTOR.term, value, 1.0, half_width)) == text
    assert messages.format_row("ab", [1.23456, -2000.0]) == "1.23 at a, -2e+03 at b"


def test_numbers_are_as_short_as_their_intervals_allow():
    value, number = messages.format_value, messages.format_number
    assert [value(1.23456, 0.1), value(1.23456, 1e-4)] == ["1.23", "1.2346"]
    assert [number(999.4), number(1234.5), number(1e7), number(0.01234)] == [
        *("999", "1,234", "1e+07", "0.0123")
    ]
    for unit, words in (" times", ["12 times", "far less likely"]), ("", ["12", "over a million"]):
        assert [messages.format_ratio(each, unit) for each in (12.3, 2e6)] == words
    assert messages.format_distinct([1234567.1, 1234567.2], 5) == ["1234567.1", "1234567.2"]
    assert messages.format_distinct([2.0, 2.0]) == ["2", "2"]
    for exact in (10.0, 1234567.8, 0.1 + 0.2):
        assert float(messages.format_exact(exact)) == exact


MECHANISMS = (
    PlanarArm(load_arm("paper-labelled")),
    SpatialRobot(arm()),
    SpatialRobot(build_planar_robot(load_arm("paper-labelled"))),
)


def test_a_number_of_a_file_is_called_what_people_call_it(snapshot: SnapshotAssertion):
    every = [each for mechanism in MECHANISMS for each in mechanism.parameters]
    assert "\n".join(f"{each.path} [{each.unit}]: {each.phrase}" for each in every) == snapshot


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
IMPOSSIBLE = restriction("coupled", value=-1.0)
UNLIKELY = restriction("coupled", value=10.2, chance=1e-3)
VERDICTS: dict[str, list[str]] = {
    "decided": judge(BEST, NEXT),
    "two levels": judge(BEST, restriction("armature")),
    "one change": judge(WRONG, changes=(HEAVIER,)),
    "one of another band": judge(WRONG, changes=(MOVED,)),
    "two changes": judge(WRONG, changes=(HEAVIER, restriction("links", value=9.9))),
    "nothing": judge(WRONG, changes=(UNLIKELY,)),
    "impossible": judge(WRONG, changes=(IMPOSSIBLE,)),
}


@pytest.mark.parametrize("name", VERDICTS)
def test_a_verdict_says(name: str, snapshot: SnapshotAssertion):
    assert "\n".join(VERDICTS[name]) == snapshot


def test_a_change_that_explains_nothing_may_be_the_likeliest():
    judgement = FileJudgement((WRONG,), (UNLIKELY,))
    assert judgement.best is WRONG
    assert judgement.likeliest is UNLIKELY
    assert _apply(LABELLED, PAYLOAD, IMPOSSIBLE.estimates) is None
    assert judgement.compare(WRONG, judgement.likeliest) == pytest.approx(101.0)
    assert judgement.compare(replace(WRONG, surprise=1e4), BEST) == pytest.approx(np.exp(690.0))


def test_friction_is_flagged_where_it_is_not_the_files():
    robot = load_robot("sliding")
    joint, own = robot.coordinate_names[0], float(robot.friction[0])
    terms = [TorqueTerm(kind, f"{kind} of {joint}", "") for kind in ("viscous", "coulomb")]
    values = (own + 0.41, own + 0.39), (0.41, 0.39)
    for term, (more, less) in require_items(zip(terms, values, strict=True)):
        for value, is_flagged in ((more, True), (less, False)):
            rubs = replace(BEST, estimates=(TermEstimate(term, value, 0.1, 0.2),))
            assert bool(flag_friction(rubs, robot, 4.0)) is is_flagged
    assert not flag_friction(replace(BEST, estimates=(DELAY,)), robot, 4.0)


@pytest.mark.parametrize("stays", [(0.3,), (2.0,), (0.09, 0.5, 2.0), (0.3, 2.0), (), (0.09,)])
def test_runs_say_whether_they_stay(stays, snapshot: SnapshotAssertion):
    windows = [made(stays_s=each, time=[1.0, 3.0], within=1.0) for each in stays]
    compared = made(windows=windows, mechanism=made(noun="robot"))
    assert "\n".join(messages._describe_runs(compared)) == snapshot
    share = np.median([each / 2.0 for each in stays]) if stays else 1.0  # of runs of 2 s
    for within in (0.49, 0.51):
        compared.windows = [made(**{**vars(each), "within": within}) for each in windows]
        leaves = vars(compare.RecordComparison)["leaves_at_once"].fget(compared)
        assert leaves == (share < compare.SOON and within < 0.5)
