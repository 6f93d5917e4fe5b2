"""Faults in the gear tree, and the check that sees each."""

from __future__ import annotations

import pytest

from tests.faults.faults import (
    ACCELERATION,
    BIAS,
    CONTACT,
    DIRECT,
    EQ13,
    FORCE,
    MASS,
    OMEGA_T,
    SHIFTED_TABLE,
    TANH,
    UNLIKE,
    Fault,
    Plant,
    assert_seen,
    edit,
)


def change(function: str, old: str, new: str) -> Plant:
    return edit(f"crosscheck.models.pinocchio.gears:{function}", old, new)


def remesh(function: str, old: str, new: str) -> Plant:
    return edit(f"crosscheck.models.pinocchio.meshes:{function}", old, new)


def rebuild(function: str, old: str, new: str) -> Plant:
    return edit(f"crosscheck.models.pinocchio.tree:{function}", old, new)


FAULTS = [
    Fault(
        "rod about its end",
        rebuild("_mass_and_inertia", "length_m**2 / 12", "length_m**2 / 3"),
        MASS,
    ),
    Fault(
        "centre of mass at half length",
        rebuild("build_tree", "link.com_m, *", "link.length_m / 2, *"),
        MASS,
    ),
    Fault(
        "payload at the elbow",
        rebuild("build_tree", "places[-1], arm.payload", "0.0, arm.payload"),
        MASS,
    ),
    Fault(
        "gravity left on", rebuild("build_tree", "np.zeros(3)", "np.array([0.0, -9.81, 0.0])"), BIAS
    ),
    Fault(
        "carrier's inertia by the sun's radius",
        rebuild("_inertias", "(r_s + r_p) ** 2", "r_s**2"),
        MASS,
    ),
    Fault(
        "planets on the base circle",
        rebuild(
            "_add_gears",
            "radius = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2",
            "radius = sum(base_radii(joint)[:2])",
        ),
        MASS,
    ),
    Fault(
        "planets without orbit inertia",
        rebuild("_add_gears", "0.0, joint.planet_mass_kg", "0.0, 0.0"),
        MASS,
    ),
    Fault("planet's inertia by the sun's radius", rebuild("_inertias", "r_p**2", "r_s**2"), MASS),
    Fault(
        "sun's equivalent mass and mass swapped",
        rebuild(
            "_add_gears",
            "joint.sun_mass_kg, sun_inertia",
            "joint.sun_equivalent_mass_kg, joint.sun_mass_kg * base_radii(joint)[0] ** 2",
        ),
        MASS,
    ),
    Fault(
        "ring on the link that it drives",
        rebuild(
            "_add_gears",
            "_load(tree, previous, place, joint.ring",
            "_load(tree, link, 0, joint.ring",
        ),
        MASS,
    ),
    Fault(
        "planet's spin sign",
        rebuild(
            "map_to_tree", "-joint.ring_teeth / joint.planet", "joint.ring_teeth / joint.planet"
        ),
        MASS,
    ),
    Fault(
        "sun turns in the link instead of its base",
        rebuild("sun_turns", "1 + joint", "joint"),
        MASS,
    ),
    Fault(
        "mass matrix without its lower half",
        change("PinocchioGears.mass_matrix", "upper + np.triu(upper, 1).T", "upper"),
        MASS,
    ),
    Fault(
        "no Coriolis force",
        change("PinocchioGears.bias", "self._data, angles, rates", "self._data, angles, 0 * rates"),
        BIAS,
    ),
    Fault(
        "motor torque without 1/n",
        change("PinocchioGears._joint_torques", "output / self._ratios[i]", "output"),
        FORCE,
    ),
    Fault(
        "controller senses the sun",
        change("PinocchioGears._joint_torques", "angles[self._links]", "angles[self._driven]"),
        FORCE,
    ),
    Fault(
        "contact without reaction",
        change(
            "PinocchioGears.contact_wrenches",
            "((mesh.planet, 1.0), (mesh.central, -1.0))",
            "((mesh.planet, 1.0),)",
        ),
        FORCE,
    ),
    Fault(
        "sign in the moment",
        change("PinocchioGears.contact_wrenches", "push[:, 1] - arm", "push[:, 1] + arm"),
        FORCE,
    ),
    Fault(
        "forces turned the wrong way",
        change("PinocchioGears._local_forces", "pose.rotation.T @", "pose.rotation @"),
        FORCE,
    ),
    Fault(
        "no pressure angle",
        change("_line_of_action", "mesh.cosine[:, None] * tangent", "tangent"),
        FORCE,
    ),
    Fault(
        "contact at the planet's share of the centre distance",
        remesh("_mesh", "teeth / (joint.sun", "joint.planet_teeth / (joint.sun"),
        FORCE,
    ),
    Fault(
        "ring mesh as an external one",
        change("_approach", "mesh.side * mesh.planet_radius", "mesh.planet_radius"),
        FORCE,
    ),
    Fault(
        "approach without the carrier", change("_approach", " - angles[mesh.link - 1]", ""), FORCE
    ),
    Fault(
        "tooth error sign",
        change("PinocchioGears._engagement", "angles) - error", "angles) + error"),
        FORCE,
    ),
    Fault(
        "stiffness does not vary",
        change("PinocchioGears._engagement", "stiffness.at(phase)", "stiffness.at(0 * phase)"),
        FORCE,
    ),
    Fault(
        "phase of the wrong joint",
        change("PinocchioGears._mesh_phases", "turned[mesh.link - 1]", "turned[0]"),
        FORCE,
    ),
    Fault(
        "phase without time",
        change("PinocchioGears._mesh_phases", "rates * t", "rates"),
        FORCE,
        OMEGA_T,
    ),
    Fault(
        "ring phase on the sun mesh",
        remesh("_mesh", "else mesh.phase_rad", "else joint.ring_mesh.phase_rad * external"),
        FORCE,
    ),
    Fault(
        "corrected ring rate is Eq. 13's",
        remesh("_ring_mesh_rate", 'ring_teeth if chosen.ring_rate == "corrected" else joint.', ""),
        FORCE,
    ),
    Fault(
        "ring rate of Eq. 13 is corrected",
        remesh("_ring_mesh_rate", ' if chosen.ring_rate == "corrected" else joint.sun_teeth', ""),
        FORCE,
        EQ13,
    ),
    Fault(
        "clearance b instead of 2 b",
        change(
            "_exact_dead_zone",
            "-mesh.backlash, mesh.backlash",
            "-mesh.backlash / 2, mesh.backlash / 2",
        ),
        FORCE,
    ),
    Fault(
        "sign in the smooth clearance",
        change("_tanh_dead_zone", "(left - right)", "(left + right)"),
        FORCE,
        TANH,
    ),
    Fault(
        "exact clearance whatever the switch",
        change("PinocchioGears._engagement", 'if self.switches.dead_zone == "exact"', "if True"),
        FORCE,
        TANH,
    ),
    Fault(
        "every mesh has the damping of all",
        remesh("_mesh", "_stage_damping(contact) / joint.planet_count", "_stage_damping(contact)"),
        FORCE,
    ),
    Fault(
        "damping by one planet's mass",
        remesh("_stage_damping", "else planets * planet", "else planet"),
        FORCE,
    ),
    Fault(
        "direct damping of the ring everywhere",
        remesh("_stage_damping", "return mesh.damping", "return joint.ring_mesh.damping"),
        FORCE,
    ),
    Fault(
        "meshes swapped",
        remesh(
            "contacts_of",
            "(+1, joint.sun_mesh), (-1, joint.ring_mesh)",
            "(+1, joint.ring_mesh), (-1, joint.sun_mesh)",
        ),
        FORCE,
    ),
    Fault(
        "dampers act in free play",
        change("PinocchioGears._mesh_forces", '== "contact"', '== "never"'),
        FORCE,
        CONTACT,
    ),
    Fault(
        "contact judged without the tooth error",
        change(
            "PinocchioGears._mesh_forces",
            "np.abs(teeth.gap) > mesh.backlash",
            "np.abs(_approach(mesh, angles)) > mesh.backlash",
        ),
        FORCE,
        CONTACT,
    ),
    Fault(
        "no contacts in the articulated body algorithm",
        change("PinocchioGears.acceleration", "torques, contacts)", "torques)"),
        ACCELERATION,
    ),
    Fault(
        "ring's sign on the way back",
        change("PinocchioGears._displacements", "planet, -r_r * theta", "planet, r_r * theta"),
        ACCELERATION,
    ),
]

SECOND_VERSION = [
    Fault(
        "weights lift",
        change(
            "PinocchioGears.__init__",
            "*arm.gravity_m_per_s2, 0.0",
            "*(-g for g in arm.gravity_m_per_s2), 0.0",
        ),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "gravity along the other axis",
        change("PinocchioGears.__init__", "gravity_m_per_s2, 0.0", "gravity_m_per_s2[::-1], 0.0"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "gravity in the bias",
        change("PinocchioGears.bias", "self._weightless", "self._tree"),
        BIAS,
        arm=UNLIKE,
    ),
    Fault(
        "friction pushes",
        change("PinocchioGears._joint_torques", "= -self._friction", "= self._friction"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "friction on the sun",
        change(
            "PinocchioGears._joint_torques", "torques[self._links] = -", "torques[self._driven] = -"
        ),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "friction of the shoulder everywhere",
        change("PinocchioGears._joint_torques", "-self._friction", "-self._friction[0]"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "motor without mass",
        rebuild("_add_drive", "place, joint.motor_mass_kg", "place, 0.0"),
        MASS,
        arm=DIRECT,
    ),
    Fault(
        "rotor without inertia",
        rebuild("_add_drive", "joint.rotor_inertia_kg_m2", "0.0"),
        MASS,
        arm=DIRECT,
    ),
    Fault(
        "rotor on the link before",
        rebuild("_add_drive", "_load(tree, link,", "_load(tree, previous,"),
        MASS,
        arm=DIRECT,
    ),
    Fault(
        "direct joint with a ratio",
        change("PinocchioGears.__init__", "else 1.0", "else 2.0"),
        FORCE,
        arm=DIRECT,
    ),
    Fault(
        "last harmonic lost",
        edit(
            "crosscheck.models.pinocchio.stiffness:_harmonics",
            "len(sizes) + 1))) @ sizes",
            "len(sizes)))) @ sizes[:-1]",
        ),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "square wave's phase turned back",
        edit(
            "crosscheck.models.pinocchio.stiffness:_square", "swing * sin(end)", "-swing * sin(end)"
        ),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "table shifted by a row",
        edit(
            "crosscheck.models.pinocchio.stiffness:curve_of", "law.stiffness_N_per_m", SHIFTED_TABLE
        ),
        FORCE,
        arm=DIRECT,
    ),
    Fault(
        "ring with the sun's law",
        remesh("stiffness_of", "contact.mesh", "contact.joint.sun_mesh"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "ring with the sun's clearance",
        remesh("_mesh", "mesh.backlash_m", "joint.sun_mesh.backlash_m"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "sun's inertia over the planet's radius",
        rebuild("equivalent_masses", "1 / r_s**2", "1 / r_p**2"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "link's inertia of a rod of its mass",
        rebuild(
            "_mass_and_inertia",
            "link.mass_kg, link.inertia_kg_m2\n    a",
            "link.mass_kg, link.mass_kg * link.length_m**2 / 12\n    a",
        ),
        MASS,
        arm=UNLIKE,
    ),
]


@pytest.mark.parametrize("fault", [*FAULTS, *SECOND_VERSION], ids=lambda fault: fault.name)
def test_fault_turns_its_check_red(fault: Fault):
    assert_seen(fault, "pinocchio:gears", "analytic:physical")
