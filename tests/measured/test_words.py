"""What a comparison with recordings says: every sentence, its numbers from made answers."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from crosscheck.recordings.compare import Repair
from crosscheck.recordings.friction import FrictionFit, JointFriction
from crosscheck.recordings.parameters import Parameter

from crosscheck.identification import compare, messages, output
from crosscheck.identification.terms import TermEstimate, TorqueTerm
from crosscheck.recordings import messages as arm_messages
from tests.loops import require_items


def made(**fields: Any) -> Any:
    return SimpleNamespace(**fields)


def estimate(kind: Any, joint: str, value: float = 0.354) -> TermEstimate:
    """0.354 with a 95 % interval of 0.0042."""
    return TermEstimate(TorqueTerm(kind, f"{kind} of {joint}", "kg m^2"), value, 0.0021, 0.0042)


J1, J2, J3 = (estimate("armature", name) for name in ("j1", "j2", "j3"))
TOLD = "armature of j3 0.3540 +- 0.0042 kg m^2"
WHERE = "By the torques of the motors"
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
    }
    return made(**plain | changes)


NOTHING = f"{WHERE} links and friction alone are not rejected."
SIDES: dict[str, tuple[Any, list[str]]] = {
    "nothing": (side(), [NOTHING]),
    "a rotor and one that is not told": (
        side(seen=(J3,), rotors=(J1, J2, J3), impossible=()),
        [
            f"{WHERE} links and friction alone are rejected: {TOLD}.",
            "Not distinguishable from zero: armature of j1 0.3540 +- 0.0042 kg m^2; "
            "armature of j2 0.3540 +- 0.0042 kg m^2.",
        ],
    ),
    "a rotor behind gears": (
        side(side="joint", seen=(J3, J2), rotors=(J3, J2)),
        [
            f"By the torques behind the gears links and friction alone are rejected: {TOLD};"
            " armature of j2 0.3540 +- 0.0042 kg m^2.",
            "Behind gears there is no rotor: are these the motors' torques (motor_torque)?",
        ],
    ),
    "what no rotor has": (
        side(impossible=(J3,), seen=(J2,), rotors=(J2, J3)),
        [f"{WHERE} no level fits: {TOLD}, which no rotor has. The model lacks something else."],
    ),
    "a lag": (
        side(delay=DELAY),
        [NOTHING, "All of these torques lag behind the motion: delay 0.00150 +- 0.00020 s."],
    ),
    "the other way round": (
        side(delay=TermEstimate(DELAY.term, -1.5e-3, 1e-4, 2e-4)),
        [NOTHING, "All of these torques come before the motion: delay -0.00150 +- 0.00020 s."],
    ),
    "what links make up": (
        side(contained=(J1.term, TorqueTerm("offset", "offset of j2", "N m"), J2.term)),
        [NOTHING, "No motion distinguishes from the links: armature of j1, armature of j2."],
    ),
    "a motion that shows little": (
        side(
            is_excited=False,
            concerned=tuple("abcdefgh"),
            condition=1234.5,
            excitation=made(motion=made(seed=17, period=6.2832), condition=45.67),
        ),
        [
            f"{WHERE} rotors and links cannot be distinguished: the motion hardly shows"
            " a, b, c, d, e, f (condition number 1234, at most 1000).",
            "Of 100 sums of sines within the joints' limits the best (seed 17, period 6.28 s) has"
            " a condition number of 46: record that one (--out FOLDER writes it as"
            " excitation.csv).",
        ],
    ),
    "a motion of which none shows more": (
        side(
            is_excited=False,
            concerned=("a",),
            condition=1001.0,
            excitation=made(motion=made(seed=3, period=2.0), condition=2345.6),
        ),
        [
            f"{WHERE} rotors and links cannot be distinguished: the motion hardly shows"
            " a (condition number 1001, at most 1000).",
            "Of 100 sums of sines within the joints' limits the best (seed 3, period 2 s) has a"
            " condition number of 2.3e+03: none shows them within these limits.",
        ],
    ),
}


@pytest.mark.parametrize("name", SIDES)
def test_a_side_says(name):
    given, said = SIDES[name]
    assert list(messages._describe_side(given)) == said


FACTOR = TermEstimate(TorqueTerm("factor", "link b", "1"), 1.25, 0.01, 0.02)


def test_links_of_the_file_say_how_far_off_they_are():
    scaled, free = made(side="between", wrong_factors=(FACTOR,), rotors=(J3,)), side()
    scaled.find_worse_joints = lambda identified: {"j2": 1.2345, "j3": 2.0}
    asks = (
        "The torques of the motors less those behind the gears ask for factors on the torques of"
        f" 1.250 +- 0.020 for {FACTOR.term.name}: the file's links or the gains are wrong, and"
        " rotors are not judged by these."
    )
    worse = (
        "Links of the file leave more than identified ones, so they are wrong:"
        " 1.23 times at j2, 2.00 times at j3."
    )
    assert list(messages._describe_scaled(scaled, free)) == [asks, worse]
    free.is_excited, scaled.wrong_factors = False, ()
    would = f"With such factors it would be: {TOLD}."
    assert list(messages._describe_scaled(scaled, free)) == [would]


def test_numbers_that_differ_never_read_the_same():
    given = side(is_excited=False, concerned=("m",), condition=1000.4, excitation=None)
    assert "(condition number 1000.4, at most 1000)" in next(messages._describe_side(given))
    assert arm_messages.format_distinct([1234567.1, 1234567.2], 5) == ["1234567.1", "1234567.2"]
    assert arm_messages.format_distinct([2.0, 2.0]) == ["2", "2"]
    for value in (10.0, 1234567.8, 0.1 + 0.2):
        assert float(arm_messages.format_exact(value)) == value


def test_an_estimate_that_another_band_moves_has_no_interval():
    apart = replace(FACTOR, doubled=1.5)
    said = "link b 1.250 1 (depends on the band: 1.500 1 in twice the band)"
    assert messages.format_estimate(apart) == said
    for there, is_flagged in ((1.275, True), (1.265, False)):
        wide = replace(FACTOR, value=there)
        (found,) = compare.flag_band_dependence((FACTOR,), (wide,))
        assert (found.doubled == there) is is_flagged
    noisy = replace(FACTOR, value=1.275, half_width=0.03)
    assert compare.flag_band_dependence((FACTOR,), (noisy,)) == (FACTOR,)


def test_the_part_of_an_error_that_other_bands_make_is_told_beside_its_estimate():
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
    assert list(output._describe_side(given)) == [
        "torques of the motors, links identified: up to 4 Hz by rows 12.3 ms apart, condition"
        " number 56.7, errors by 20 blocks",
        "  link b 1.250 +- 0.020 1",
        "  link b 1.250 +- 0.020 1, 60% of its error by other bands",
        "  up to 2 Hz: link b 1.250 +- 0.020 1",
        "  up to 8 Hz: nothing to estimate",
    ]


def prior(level: str | None = "coupled", **changes: Any) -> Any:
    armature = made(level="armature", chi_squared=123.456)
    best = made(
        level="coupled", chi_squared=23.4567, estimates=(J3, FACTOR), surprise=98.765, shown=12
    )
    plain = {"is_surprising": False, "is_impossible": False, "fits": (armature, best)}
    return made(**plain | {"best": best, "level": level} | changes)


def test_links_known_to_a_share_say_which_level_it_is():
    head, sizes = "With the file's links known to 5.5 %", "123.46 for armature and 23.457 for"
    said = {
        f"{head} the torques are those of coupled (chi squared {sizes} coupled): {TOLD}.": prior(),
        f"{head} armature and coupled cannot be distinguished (chi squared {sizes} coupled): links"
        " have to be known to less than inertia times ratio of the rotors.": prior(None),
        f"{head} nothing fits: they would be further from the file (chi squared 98.77 of 12"
        " parameters). No level is named.": prior(is_surprising=True),
        f"{head} no level has possible bodies that explain the torques. None is named.": prior(
            is_impossible=True
        ),
        f"{head}: {TOLD}. The file has no rotors, so coupled is not asked.": prior(fits=(1,)),
    }
    for text, refinement in require_items(said.items()):
        assert messages._describe_prior(refinement, 0.055) == text


def test_possible_bodies_are_told_from_none():
    def bodies(explain: bool, *border: str) -> Any:
        return made(explain=explain, border=border, impossible=("a", "b"), excess=1234.56)

    told = messages._describe_bodies
    as_well = "At coupled possible bodies explain the torques as well as any"
    assert told("coupled", bodies(True)) == f"{as_well}."
    at_border = "; at the border: what j1, j2 move"
    assert told("coupled", bodies(True, "j1", "j2")) == f"{as_well}{at_border}."
    assert told("coupled", bodies(False, "j1", "j2")) == (
        "At coupled no possible bodies explain the torques: what a, b move would be none"
        f" (possible ones leave 1235 more of chi squared{at_border})."
    )


def test_levels_that_are_one_model_are_said_to_be():
    def levels(**ranks: Any) -> list[str]:
        return list(messages._describe_levels(made(ranks=made(**ranks))))

    same = (
        "Coupled and armature are the same model with other links{}: no recording distinguishes"
        " them unless the links are known otherwise, or those of one are no possible bodies"
        " ([prior] bodies)."
    )
    assumed = ", where stators are on the links before the joints"
    assert levels(are_equal=True, assumed=True) == [same.format(assumed)]
    assert levels(are_equal=True, assumed=False) == [same.format("")]
    assert levels(are_equal=False, coupled=30, armature=31, both=33) == [
        "Coupled and armature differ for any links (ranks 30, 31, together 33): a stator is not on"
        " the link before its joint, or its axis is another."
    ]


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


def test_numbers_of_an_arms_record_are_as_short_as_their_intervals_allow():
    value, number = arm_messages.format_value, arm_messages.format_number
    assert [value(1.23456, 0.1, 1.0), value(1.23456, 1e-4, 1.2345)] == ["1.23", "1.2346"]
    assert value(1.23456, 1e-9, 1.2) == "1.2346"  # of its change, 0.035, 1 % is lost at most
    assert [number(999.4), number(1234.5), number(1e7), number(0.01234)] == [
        *("999", "1,234", "1e+07", "0.0123")
    ]
    assert arm_messages.format_values(np.array([1.23456, 2.0])) == "1.23, 2"
    assert arm_messages.format_values([1.23456], 2) == "1.2"
    assert [arm_messages.likelihood(each) for each in (12.3, 1e12)] == ["12", "over 1e+12"]


MASS = made(name="arm.payload_mass_kg", phrase="the payload's mass", unit="kg", value=20.0)


PARAMETERS = {
    "arm.payload_mass_kg": ("kg", "payload", "the payload"),
    "arm.links.1.inertia_kg_m2": ("kg m^2", "link 2: inertia", "the inertia of link 2"),
    "arm.links.0.density_kg_per_m3": ("kg/m^3", "link 1: density", "the density of link 1"),
    "arm.joints.0.friction_N_m_s_per_rad": (
        "N m s/rad",
        "joint 1: viscous friction",
        "the viscous friction of joint 1",
    ),
    "arm.joints.2.rotor_inertia_kg_m2": (
        "kg m^2",
        "joint 3: rotor inertia",
        "the rotor inertia of joint 3",
    ),
}


@pytest.mark.parametrize("path", PARAMETERS)
def test_a_number_of_the_file_is_called_what_people_call_it(path):
    parameter = Parameter(path, 1.0)
    assert (parameter.unit, parameter.name, parameter.phrase) == PARAMETERS[path]


def change(**changes: Any) -> Any:
    plain = {"value": 23.4567, "half_width": 0.01, "is_possible": True, "left": 1234.5}
    return made(parameter=MASS, **plain | changes)


def test_a_change_of_a_number_is_told_with_the_files():
    left = "the file says 20; leaves a chi squared of 1,234 per degree of freedom"
    said = "arm.payload_mass_kg 23.4567 +- 0.01 kg (95 %)"
    assert arm_messages.format_estimate(change()) == f"{said}; {left}"
    impossible = arm_messages.format_estimate(change(is_possible=False))
    assert impossible == f"{said}, which is impossible; {left}"


def record(**changes: Any) -> Any:
    levels = [made(name=name, ratio=ratio) for name, ratio in (("coupled", 1.0), ("links", 30.0))]
    plain = {
        "levels": (*levels, made(name="armature", ratio=4.0)),
        "best": levels[0],
        "residual_chi2": 246.9,
        "residual_freedom": 200,
        "explanations": (),
        "decided": False,
        "explained": False,
        "candidates": ("coupled", "armature"),
        "single": (),
        "repairs": (),
    }
    return made(**plain | changes)


ARM: Any = made(name="an arm that can be")
REPAIR = Repair("links", change(), ARM)
FRICTION = FrictionFit("armature", (JointFriction(1, 1.5, 0.1, 0.25, 0.01, 0.1),), 9.0, 1.0, ARM)
REPAIRED = "links alone (links) if the payload's mass is 23.46 kg; the file says 20."
RUBBED = (
    "gears' inertia on the diagonal (armature) with friction: joint 1: Coulomb 1.5 N m (the file"
    " has none) and viscous 0.25 N m s/rad (the file says 0.1)."
)
LEFT = "chi squared is 1.23 per degree of freedom"
NONE = "No model fits the recording with the file's numbers"
VERDICTS: dict[str, tuple[Any, list[str]]] = {
    "decided": (
        record(decided=True, explained=True),
        [
            "The recording fits rigid gears (coupled) with the file's numbers.",
            f"It leaves noise alone ({LEFT}); armature, the next best, is 4 times less likely.",
        ],
    ),
    "explained": (
        record(explained=True),
        [
            "The recording fits coupled and armature with the file's numbers and does not"
            " distinguish them.",
            f"All of these leave noise alone ({LEFT} of coupled).",
        ],
    ),
    "one change": (
        record(explanations=(REPAIR,)),
        [f"The recording fits {REPAIRED}", f"{NONE}; nearest is coupled ({LEFT})."],
    ),
    "two changes": (
        record(explanations=(FRICTION, REPAIR)),
        [
            f"The recording fits {RUBBED}",
            "The recording cannot tell these apart from it:",
            f"it fits {REPAIRED}",
            f"{NONE}; nearest is coupled ({LEFT}).",
        ],
    ),
    "nothing": (
        record(single=(change(is_possible=False), change())),
        [
            f"{NONE}.",
            f"Nearest is coupled ({LEFT}); no one number, no friction and no gravity"
            " explains the rest.",
            f"The change that explains most: {arm_messages.format_estimate(change())}.",
        ],
    ),
    "impossible": (
        record(repairs=(made(arm=None, level="links", estimate=change()), made(arm=1))),
        [
            f"{NONE}.",
            f"Nearest is coupled ({LEFT}); no one number, no friction and no gravity"
            " explains the rest.",
            "links alone (links) would need the payload's mass to be 23.46 kg, which is"
            " impossible.",
        ],
    ),
}


@pytest.mark.parametrize("name", VERDICTS)
def test_a_verdict_says(name):
    given, said = VERDICTS[name]
    assert list(arm_messages._describe_verdict(given)) == said


def test_changes_and_runs_are_told_in_their_units():
    figures = {
        "with the file's numbers": None,
        "with Coulomb and viscous friction as estimated": FRICTION,
        "with arm.payload_mass_kg 23.46 kg": REPAIR,
    }
    for words, explanation in figures.items():
        assert arm_messages.change_words(explanation) == words
    windows = [
        made(stays_s=stays, time=[1.0, 1.0 + long], within=within)
        for stays, long, within in ((0.1, 2.0, 0.5), (0.4, 3.0, 1.0), (0.3, 2.5, 0.84))
    ]
    both = ["links", "coupled"]
    best = made(name="links")
    runs = made(windows=windows, best=best, levels=both)
    assert list(arm_messages._describe_runs(runs)) == [
        "Simulated from 3 recorded states, links leaves its uncertainty band (3 sigma) after 0.3 s"
        " of 2.5 s (median); 78 % of the rows are within 2 sigma."
    ]
    window = made(stays_s=2.0, time=[1.0, 3.0], within=1.0)
    runs = made(windows=[window], best=best, levels=both)
    assert list(arm_messages._describe_runs(runs)) == [
        "Simulated from 1 recorded state, links stays in its uncertainty band (3 sigma) for 2 s"
        " of 2 s; 100 % of the rows are within 2 sigma."
    ]
    assert list(arm_messages._describe_runs(made(windows=[]))) == []
