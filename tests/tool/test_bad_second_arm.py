"""Bad arm files with all sorts of joints: one line with file, field and value; nothing written."""

from __future__ import annotations

import pytest

from crosscheck.models.files import HERE
from tests.tool.test_bad_input import assert_one_line

UNLIKE = (HERE / "arms" / "three-unlike.toml").read_text(encoding="utf-8")
BETWEEN = (HERE / "arms" / "direct-between.toml").read_text(encoding="utf-8")
SINE = 'stiffness = { law = "sine", mean_N_per_m = 1.05e8, amplitude_N_per_m = 1.9e7 }'
SUN, RING = "joints[0].sun_mesh", "joints[0].ring_mesh"
BAD_SECOND_ARMS = {
    "unknown kind of joint": (
        UNLIKE,
        'kind = "planetary"',
        'kind = "harmonic"',
        ("joints[0]", "'harmonic'", "'planetary'", "'direct'"),
    ),
    "no kind of joint": (UNLIKE, 'kind = "planetary"\n', "", ("joints[0]", "table with a kind")),
    "unknown law": (UNLIKE, SINE, SINE.replace("sine", "cosine"), (SUN, "'cosine'", "'fourier'")),
    "no law": (UNLIKE, SINE, SINE.replace('law = "sine", ', ""), (SUN, "table with a law")),
    "a number for a law": (
        UNLIKE,
        SINE,
        "stiffness = 1e8",
        (f"{SUN}.stiffness", "100000000.0", "must be a table"),
    ),
    "amplitude beyond the mean": (
        UNLIKE,
        "amplitude_N_per_m = 1.9e7",
        "amplitude_N_per_m = 1.9e8",
        (f"{SUN}.stiffness.amplitude_N_per_m", "190000000.0", "1.05e+08"),
    ),
    "key of another law": (
        UNLIKE,
        SINE,
        SINE.replace(" }", ", harmonics = 3 }"),
        (f"{SUN}.stiffness.harmonics", "unknown key"),
    ),
    "waves that turn negative": (
        UNLIKE,
        "cosine_N_per_m = [6e6, -3.5e6]",
        "cosine_N_per_m = [1.6e8, -3.5e6]",
        (f"{RING}.stiffness.mean_N_per_m", "120000000.0", "positive"),
    ),
    "fifty-one waves": (
        UNLIKE,
        "cosine_N_per_m = [6e6, -3.5e6]",
        f"cosine_N_per_m = {[1.0] * 51}",
        (f"{RING}.stiffness.cosine_N_per_m", "50"),
    ),
    "a number for waves": (
        UNLIKE,
        "cosine_N_per_m = [6e6, -3.5e6]",
        "cosine_N_per_m = 6e6",
        (f"{RING}.stiffness.cosine_N_per_m", "6000000.0", "must be a list"),
    ),
    "square wave upside down": (
        UNLIKE,
        "largest_N_per_m = 7.6e7",
        "largest_N_per_m = 5.3e7",
        ("joints[1].sun_mesh.stiffness.largest_N_per_m", "53000000.0", "5.4e+07"),
    ),
    "square wave that undershoots zero": (
        UNLIKE,
        "largest_N_per_m = 7.6e7",
        "largest_N_per_m = 9e8",
        ("joints[1].sun_mesh.stiffness.least_N_per_m", "54000000.0", "undershoots"),
    ),
    "no harmonics": (
        UNLIKE,
        "harmonics = 5",
        "harmonics = 0",
        ("joints[1].sun_mesh.stiffness.harmonics", "0", "1 to 50"),
    ),
    "more than two pairs of teeth": (
        UNLIKE,
        "contact_ratio = 1.62",
        "contact_ratio = 2.3",
        ("joints[1].sun_mesh.stiffness.contact_ratio", "2.3", "1 to 2"),
    ),
    "table that does not close": (
        BETWEEN,
        "8.6e7, 9.2e7,\n]",
        "8.6e7, 9.3e7,\n]",
        (f"{SUN}.stiffness.stiffness_N_per_m", "periodic", "9.3e+07"),
    ),
    "table of half a period": (
        BETWEEN,
        "0.92, 1.0,",
        "0.92, 0.95,",
        (f"{SUN}.stiffness.phase_cycles", "from 0 to 1"),
    ),
    "table that goes back": (
        BETWEEN,
        "0.32, 0.41, 0.5",
        "0.41, 0.32, 0.5",
        (f"{SUN}.stiffness.phase_cycles", "increase"),
    ),
    "table with a value missing": (
        BETWEEN,
        "9.2e7, 1.01e8,",
        "9.2e7,",
        (f"{SUN}.stiffness.stiffness_N_per_m", "13 values"),
    ),
    "table not positive": (
        BETWEEN,
        "1.01e8, 1.1e8",
        "-1.01e8, 1.1e8",
        (f"{SUN}.stiffness.stiffness_N_per_m[1]", "-101000000.0", "1 to 1e12 N/m"),
    ),
    "spline that dips below zero": (
        BETWEEN,
        "9.7e7, 8.9e7, 8.4e7, 8.3e7",
        "9.7e9, 8.9e7, 8.4e7, 8.3e7",
        (f"{SUN}.stiffness.stiffness_N_per_m", "spline", "between rows"),
    ),
    "both forms of an inertia": (
        UNLIKE,
        "sun_equivalent_mass_kg = 0.62",
        "sun_equivalent_mass_kg = 0.62\nsun_inertia_kg_m2 = 1e-4",
        ("joints[0].sun_equivalent_mass_kg", "0.62", "either", "sun_inertia_kg_m2"),
    ),
    "no form of an inertia": (
        UNLIKE,
        "carrier_equivalent_mass_kg = 5.2\n",
        "",
        ("joints[0].carrier_equivalent_mass_kg", "either", "carrier_inertia_kg_m2"),
    ),
    "no inertia to speak of": (
        UNLIKE,
        "planet_inertia_kg_m2 = 4.1e-4",
        "planet_inertia_kg_m2 = 4.1e-12",
        ("joints[1].planet_inertia_kg_m2", "4.1e-12", "at least"),
    ),
    "both ways to damp": (
        UNLIKE,
        "damping_ratio = 0.06",
        "damping_ratio = 0.06\ndamping_N_s_per_m = 1.0",
        (f"{RING}.damping_ratio", "0.06", "damping itself"),
    ),
    "no way to damp": (
        UNLIKE,
        "damping_ratio = 0.06\n",
        "",
        (f"{RING}.damping_ratio", "damping itself"),
    ),
    "no sun mesh": (
        UNLIKE,
        "[joints.sun_mesh]",
        "[joints.sun]",
        ("joints[0].sun", "unknown key", "sun_mesh"),
    ),
    "rod and body in one": (
        UNLIKE,
        "mass_kg = 11.4",
        "density_kg_per_m3 = 2700.0\nmass_kg = 11.4",
        ("links[1].mass_kg", "11.4", "either"),
    ),
    "half a rod": (
        UNLIKE,
        "cross_section_m2 = 0.0095\n",
        "",
        ("links[0].cross_section_m2", "missing", "density_kg_per_m3"),
    ),
    "half a body": (
        UNLIKE,
        "inertia_kg_m2 = 0.43",
        "",
        ("links[1].inertia_kg_m2", "missing", "mass_kg"),
    ),
    "neither rod nor body": (
        UNLIKE,
        "mass_kg = 11.4\ninertia_kg_m2 = 0.43",
        "",
        ("links[1].cross_section_m2", "mass_kg"),
    ),
    "gravity in space": (
        UNLIKE,
        "[1.703, -9.661]",
        "[1.703, -9.661, 0.0]",
        ("gravity_m_per_s2", "at most 2", "3"),
    ),
    "gravity along one axis": (
        UNLIKE,
        "[1.703, -9.661]",
        "[-9.81]",
        ("gravity_m_per_s2[1]", "missing"),
    ),
    "gravity as a number": (
        UNLIKE,
        "[1.703, -9.661]",
        "-9.81",
        ("gravity_m_per_s2", "-9.81", "must be a list"),
    ),
    "gravity of a star": (
        UNLIKE,
        "[1.703, -9.661]",
        "[1.703, -9661.0]",
        ("gravity_m_per_s2[1]", "-9661.0", "-1000 to 1000 m/s^2"),
    ),
    "friction that pushes": (
        UNLIKE,
        "friction_N_m_s_per_rad = 6.5",
        "friction_N_m_s_per_rad = -6.5",
        ("joints[0].friction_N_m_s_per_rad", "-6.5", "0, or 1e-15"),
    ),
    "direct joint with gears": (
        BETWEEN,
        "motor_mass_kg = 5.8",
        "motor_mass_kg = 5.8\nsun_teeth = 30",
        ("joints[1].sun_teeth", "30", "unknown key"),
    ),
    "direct joint without a motor": (
        BETWEEN,
        "motor_mass_kg = 5.8\n",
        "",
        ("joints[1].motor_mass_kg", "missing"),
    ),
    "motor of negative mass": (
        BETWEEN,
        "motor_mass_kg = 5.8",
        "motor_mass_kg = -5.8",
        ("joints[1].motor_mass_kg", "-5.8", "0, or 1e-12"),
    ),
    "a mesh's key in its joint": (
        UNLIKE,
        "ring_mass_kg = 9.4",
        "ring_mass_kg = 9.4\nbacklash_m = 1e-5",
        ("joints[0].backlash_m", "1e-05", "unknown key"),
    ),
    "another version": (
        UNLIKE,
        "schema_version = 2",
        "schema_version = 3",
        ("schema_version", "3", "must be 2"),
    ),
}


@pytest.mark.parametrize("case", BAD_SECOND_ARMS)
def test_bad_arm_is_named_with_field_and_value(short, tmp_path, case):
    whole, old, new, fragments = BAD_SECOND_ARMS[case]
    text = whole.replace(old, new, 1)
    assert text != whole
    file = tmp_path / "arm.toml"
    file.write_text(text)
    assert_one_line(short(arm=file), str(file), *fragments)
    assert list(tmp_path.iterdir()) == [file]
