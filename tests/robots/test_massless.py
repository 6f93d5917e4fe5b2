"""Links without mass, mimics of mimics, inertias that are rounding: M as a whole is regular."""

import numpy as np
import pytest

from crosscheck.checks.robot_states import sample_states
from crosscheck.models.mechanism import select_mechanism
from crosscheck.planning.robots import compare_engines
from crosscheck.registry import build_robot_model
from tests.loops import require_items
from tests.robots.chains import LIMIT, Solid, joint, link, mass_matrices, robot, urdf

GROUND = link("ground")
ARM = Solid(1.0, (0.2, 0, 0), (0.01, 0, 0, 0.04, 0, 0.04))
Y = (0.0, 1.0, 0.0)


def test_a_link_between_two_joints_needs_no_mass():
    """Pan and tilt of a rod: about the pan 0.01 sin^2 + (0.04 + 1 0.2^2) cos^2 kg m^2."""
    own = robot(
        urdf(
            *(GROUND, link("fork"), link("arm", ARM)),
            joint("pan", "ground", "fork"),
            joint("tilt", "fork", "arm", axis=Y),
        )
    )
    assert own.notes == ("link fork has no mass and inertia of its own",)
    pan = 0.01 * np.sin(0.7) ** 2 + 0.08 * np.cos(0.7) ** 2
    for mass in require_items(mass_matrices(own, (0.4, 0.7))):
        assert mass == pytest.approx(np.diag([pan, 0.08]), abs=1e-15)


ROTOR = {"kind": "geared", "ratio": 50.0, "rotor_inertia_kg_m2": 1e-4}
SPIN = ROTOR | {"stator": "u", "rotor_axis": [1.0, 0.0, 0.3]}
LEADS = joint("x", "u", "arm", axis=Y, more=f'<mimic joint="t"/>{LIMIT}')
ON_MASSLESS = {
    "a rotor": ((link("arm", ARM), joint("t", "u", "arm", axis=Y)), {"t": SPIN}),
    "a leader": ((link("lead"), link("arm", ARM), joint("t", "u", "lead", axis=Y), LEADS), {}),
    "an inertia": ((link("a", Solid(0.0)), link("arm", ARM), joint("t", "u", "a"), LEADS), {}),
}


@pytest.mark.parametrize("case", ON_MASSLESS)
def test_what_has_no_mass_may_stand_on_a_link_without_mass(case):
    """No engine divides by the mass of both."""
    parts, gears = ON_MASSLESS[case]
    own = robot(urdf(GROUND, link("u"), joint("p", "ground", "u"), *parts), gears)
    findings = compare_engines(own, sample_states(own, 5, 0))
    assert {each.verdict for each in require_items(findings)} == {"agree"}


def test_armature_of_dynamics_counts_beside_rotors_and_with_followers():
    """Of a follower by its multiplier squared; of a joint with a rotor that alone counts.

    What else a joint states leaves it alone.
    """
    dynamics = '<dynamics armature="{}"/>' + LIMIT
    follow = '<mimic joint="turn" multiplier="-3"/>' + dynamics.format(0.2)
    own = robot(
        urdf(
            *(GROUND, *(link(name, ARM) for name in "abc")),
            joint("turn", "ground", "a", axis=Y, more=dynamics.format(0.1)),
            joint("follow", "a", "b", axis=Y, at=(0.4, 0, 0), more=follow),
            joint("geared", "b", "c", at=(0.4, 0, 0), more=dynamics.format(7)),
        ),
        {"geared": ROTOR, "turn": {"kind": "direct", "friction_N_m_s_per_rad": 0.5}},
    )
    assert own.armature == pytest.approx([0.1 + 9 * 0.2, 0.0])
    assert own.notes[0].startswith("armature of turn, follow is on the diagonal of M")
    findings = compare_engines(own, sample_states(own, 5, 0))
    assert {each.verdict for each in require_items(findings)} == {"agree"}
    links, armature = (
        build_robot_model("analytic", own, level).mass_matrix(np.zeros((1, 2)))[0]
        for level in ("links", "armature")
    )
    assert armature - links == pytest.approx(np.diag([1.9, 0.25]), abs=1e-12)


def test_mimics_of_mimics_follow_the_first_by_products_and_offsets():
    """q2 = 0.5 q1 + 0.1 and q3 = -0.5 q2 + 0.2 are q3 = -0.25 q1 + 0.15; the order is no matter.

    The first moves no mass itself.
    """
    names = ("c", "b", "a")
    mimics = {
        "c": '<mimic joint="to b" multiplier="-0.5" offset="0.2"/>',
        "b": '<mimic joint="to a" multiplier="0.5" offset="0.1"/>',
        "a": "",
    }
    text = urdf(
        GROUND,
        *(link("c", ARM), link("b", ARM), link("a")),
        *(joint(f"to {n}", "ground", n, axis=Y, more=mimics[n] + LIMIT) for n in names),
    )
    own = robot(text)
    factors, offsets = own.joint_map
    assert factors.ravel() == pytest.approx([-0.25, 0.5, 1.0], rel=1e-15)
    assert offsets == pytest.approx([0.15, 0.1, 0.0], rel=1e-15)
    for mass in require_items(mass_matrices(own, (0.3,))):
        assert mass == pytest.approx(0.08 * (0.25 + 0.0625), rel=1e-14)


@pytest.mark.parametrize(
    ("size", "reach", "notes"),
    [(2.4e-35, 0.4, 1), (1e-18, 0.4, 1), (1e-8, 0.4, 0), (1e-17, 0.04, 0), (1e-13, 40.0, 1)],
)
def test_an_inertia_that_is_rounding_is_zero(size, reach, notes):
    """Of a point mass, as programs write it: below eps m reach^2, whatever the reach [m]."""
    dust = Solid(1.3, (reach / 20, -reach / 4, 0), (size, 0, -notes * size, size, 0, size))
    arm = Solid(1.0, (reach / 2, 0, 0), tuple(reach**2 / 4 * each for each in ARM.inertia))
    own = robot(
        urdf(
            *(GROUND, link("arm", arm), link("head", dust), joint("turn", "ground", "arm", axis=Y)),
            joint("nod", "arm", "head", axis=Y, at=(reach, 0, 0)),
        )
    )
    rounded = [note for note in own.notes if note.startswith("link head: an inertia of")]
    assert [note.endswith("used as zero") for note in rounded] == notes * [True]
    assert own.bodies[1].inertia.any() != bool(notes)


@pytest.mark.parametrize(("mass", "notes"), [(1800.0, 0), (2200.0, 1)])
def test_a_link_that_is_absurdly_heavy_is_doubted(mass, notes):
    """Beside others of 1 and 3 kg, whose median is 2 kg."""
    masses = {"a": 1.0, "b": 3.0, "ball": mass}
    own = robot(
        urdf(
            GROUND,
            *(link(name, Solid(mass)) for name, mass in masses.items()),
            *(joint(f"to {n}", p, n) for n, p in zip(masses, ("ground", *masses), strict=False)),
        )
    )
    assert [note.partition(" kg")[0] for note in own.notes] == notes * ["link ball: 2200"]


def test_a_mass_can_be_set_where_another_is_too_small_to_state(tmp_path):
    tool = Solid(1e-15, inertia=(1e-11, 0, 0, 1e-11, 0, 1e-11))
    text = urdf(
        *(GROUND, link("arm", ARM), link("t", tool)),
        *(joint("turn", "ground", "arm"), joint("f", "arm", "t", "fixed")),
    )
    (tmp_path / "mine.urdf").write_text(text)
    changed = select_mechanism(
        str(tmp_path / "mine.urdf"), (), ["robot.links.arm.mass_kg=2.0"]
    ).mechanism
    assert changed.bodies[0].mass == pytest.approx(2.0)
