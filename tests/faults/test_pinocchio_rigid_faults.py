"""Faults in the rigid levels, and the check that sees each."""

from __future__ import annotations

import pytest

from tests.faults.faults import (
    ACCELERATION,
    BIAS,
    DIRECT,
    FORCE,
    MASS,
    UNLIKE,
    Fault,
    Plant,
    assert_seen,
    edit,
)


def change(function: str, old: str, new: str) -> Plant:
    return edit(f"crosscheck.models.pinocchio.rigid:{function}", old, new)


GIVEN = "PinocchioLinks.__init__"

LINKS = [
    Fault("rod about its end", change("_mass_and_inertia", "**2 / 12", "**2 / 3"), MASS),
    Fault(
        "centre of mass at half length",
        change("_links_and_payload", "link.com_m", "link.length_m / 2"),
        MASS,
    ),
    Fault("payload at the elbow", change("_links_and_payload", "0.0, reach)", "0.0, 0.0)"), MASS),
    Fault(
        "elbow at the centre of mass",
        change("_links_and_payload", "reach = link.length_m", "reach = link.com_m"),
        MASS,
    ),
    Fault(
        "gravity left on",
        change("_links_and_payload", "np.zeros(3)", "np.array([0.0, -9.81, 0.0])"),
        BIAS,
    ),
    Fault("no Coriolis force", change("PinocchioLinks.bias", "q, v)", "q, 0 * v)"), BIAS),
    Fault(
        "mass matrix without its lower half",
        change("PinocchioLinks.mass_matrix", "upper + np.triu(upper, 1).T", "upper"),
        MASS,
    ),
    Fault(
        "controller with the shoulder's gains",
        change("PinocchioLinks.driving_torques", "gains[i]", "gains[0]"),
        FORCE,
    ),
    Fault(
        "controller senses the shoulder",
        change("PinocchioLinks.driving_torques", "q[i]", "q[0]"),
        FORCE,
    ),
    Fault(
        "acceleration without Coriolis force",
        change("PinocchioLinks.acceleration", "_data, q, v, self", "_data, q, 0 * v, self"),
        ACCELERATION,
    ),
    Fault(
        "weights lift",
        change(GIVEN, "*arm.gravity_m_per_s2, 0.0", "*(-g for g in arm.gravity_m_per_s2), 0.0"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "gravity along the other axis",
        change(GIVEN, "gravity_m_per_s2, 0.0", "gravity_m_per_s2[::-1], 0.0"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "gravity in the bias",
        change("PinocchioLinks.bias", "self._weightless", "self._tree"),
        BIAS,
        arm=UNLIKE,
    ),
    Fault(
        "acceleration without weights",
        change("PinocchioLinks.acceleration", "pin.aba(self._tree", "pin.aba(self._weightless"),
        ACCELERATION,
        arm=UNLIKE,
    ),
    Fault(
        "friction pushes",
        change("PinocchioLinks._joint_torques", "- self._friction", "+ self._friction"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "friction of the shoulder everywhere",
        change("PinocchioLinks._joint_torques", "self._friction *", "self._friction[0] *"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "link's inertia of a rod of its mass",
        change(
            "_mass_and_inertia",
            "link.mass_kg, link.inertia_kg_m2\n    a",
            "link.mass_kg, link.mass_kg * link.length_m**2 / 12\n    a",
        ),
        MASS,
        arm=UNLIKE,
    ),
]

CARRIERS = [
    Fault("planets without orbit inertia", change("PinocchioCarriers._build", "+ orbit", ""), MASS),
    Fault(
        "orbit of one planet", change("PinocchioCarriers._build", "joint.planet_count * ", ""), MASS
    ),
    Fault(
        "joint mass on its own link",
        change(
            "PinocchioCarriers._build",
            "_attach_to_previous(tree, number, _joint_mass(joint), joint.ring_inertia_kg_m2)",
            "_attach(tree, number, _joint_mass(joint), joint.ring_inertia_kg_m2, 1.0)",
        ),
        MASS,
    ),
    Fault(
        "ring's inertia on the link that it drives",
        change(
            "PinocchioCarriers._build",
            "joint.ring_inertia_kg_m2)",
            "0.0), _attach(tree, number, 0.0, joint.ring_inertia_kg_m2)",
        ),
        MASS,
    ),
    Fault("joint mass without the ring", change("_joint_mass", " + joint.ring_mass_kg", ""), MASS),
    Fault("joint mass with one planet", change("_joint_mass", "joint.planet_count * ", ""), MASS),
    Fault(
        "carrier's inertia by the pitch radius",
        change("_carrier_inertia", " * cos(radians(joint.pressure_angle_deg))", ""),
        MASS,
    ),
    Fault(
        "joint mass at the centre of the base",
        change("_attach_to_previous", "translation[0]", "translation[1]"),
        MASS,
    ),
    Fault(
        "motor without mass",
        change("_attach_motor", "joint.motor_mass_kg", "0.0"),
        MASS,
        arm=DIRECT,
    ),
    Fault(
        "rotor without inertia",
        change("_attach_motor", "joint.rotor_inertia_kg_m2", "0.0"),
        MASS,
        arm=DIRECT,
    ),
    Fault(
        "motor on its own link",
        change(
            "_attach_motor",
            "_attach_to_previous(tree, number, joint.motor_mass_kg, 0.0)",
            "_attach(tree, number, joint.motor_mass_kg, 0.0, 1.0)",
        ),
        MASS,
        arm=DIRECT,
    ),
    Fault(
        "given inertia times the squared radius",
        change("_inertia", "return given", "return given * radius**2"),
        MASS,
        arm=UNLIKE,
    ),
]

ARMATURE = [
    Fault(
        "planet's spin without the carrier's",
        change("_reflected_inertia", "1 - joint.ring", "joint.ring"),
        MASS,
    ),
    Fault(
        "sun's ratio without the carrier's turn",
        change("_reflected_inertia", "1 + joint.ring", "joint.ring"),
        MASS,
    ),
    Fault(
        "reflected inertia of one planet",
        change("_reflected_inertia", "joint.planet_count * ", ""),
        MASS,
    ),
    Fault("ratio for its square", change("_reflected_inertia", "sun**2", "sun"), MASS),
    Fault(
        "pitch for base radius",
        change("_base_radius", " * cos(radians(joint.pressure_angle_deg))", ""),
        MASS,
    ),
    Fault(
        "armature of the shoulder everywhere",
        change(
            "PinocchioArmature._build",
            "_reflected_inertia(joint)",
            "_reflected_inertia(self.arm.joints[0])",
        ),
        MASS,
    ),
    Fault(
        "rotor of a direct joint counted twice",
        change("_reflected_inertia", "return 0.0", "return joint.rotor_inertia_kg_m2"),
        MASS,
        arm=DIRECT,
    ),
]

COUPLED = [
    Fault(
        "planet's spin sign",
        change("_add_gears", "-joint.ring_teeth / joint.planet", "joint.ring_teeth / joint.planet"),
        MASS,
    ),
    Fault(
        "sun's ratio without the carrier's turn",
        change("_add_gears", "1 + joint.ring", "joint.ring"),
        MASS,
    ),
    Fault(
        "sun on the link that it drives",
        change("_add_gears", "tree.parents[number], (x, y)", "number, (0.0, 0.0)"),
        MASS,
    ),
    Fault("planets on half the circle", change("_add_gears", "2 * pi", "pi"), MASS),
    Fault(
        "planet with the sun's inertia",
        change("_add_gears", "_planet_inertia(joint)", "_sun_inertia(joint)"),
        MASS,
    ),
    Fault(
        "planet and sun swapped in mass",
        change("_add_gears", "planet, joint.planet_mass_kg", "planet, joint.sun_mass_kg"),
        MASS,
    ),
    Fault(
        "planets on the base circle",
        change("_carrier_radius", "/ 2", "/ 2 * cos(radians(joint.pressure_angle_deg))"),
        MASS,
    ),
    Fault(
        "ring without mass", change("PinocchioCoupled._build", "joint.ring_mass_kg", "0.0"), MASS
    ),
    Fault(
        "acceleration without Coriolis force",
        change("PinocchioCoupled.acceleration", "self._data, q, v)", "self._data, q, 0 * v)"),
        ACCELERATION,
    ),
    Fault(
        "acceleration without weights",
        change("PinocchioCoupled.acceleration", "pin.nle(self._tree", "pin.nle(self._weightless"),
        ACCELERATION,
        arm=UNLIKE,
    ),
    Fault(
        "motor without mass, rotor without inertia",
        change("PinocchioCoupled._build", "_attach_motor(tree, number, joint)", "pass"),
        MASS,
        arm=DIRECT,
    ),
]

LEVELS = {"links": LINKS, "carriers": CARRIERS, "armature": ARMATURE, "coupled": COUPLED}


@pytest.mark.parametrize(
    ("level", "fault"),
    [
        pytest.param(level, fault, id=f"{level}: {fault.name}")
        for level, faults in LEVELS.items()
        for fault in faults
    ],
)
def test_fault_turns_its_check_red(level: str, fault: Fault):
    assert_seen(fault, f"pinocchio:{level}", f"analytic:{level}")
