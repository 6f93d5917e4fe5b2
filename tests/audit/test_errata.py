"""The errata finder finds what is wrong, and nothing else."""

import math
import re
from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
import sympy as sp
import xarray as xr

from crosscheck.analytic.derivation.bodies import build_bodies
from crosscheck.analytic.derivation.forms import Form, mass_matrix
from crosscheck.analytic.derivation.lagrange import build_mass_terms
from crosscheck.analytic.derivation.symbols import build_symbolic_chain
from crosscheck.analytic.paper.energies import build_energies_form, kinetic_energies
from crosscheck.analytic.paper.printed import build_printed_form
from crosscheck.audit.errata import (
    auxiliary,
    energy,
    entry_differences,
    planted_faults,
    statements,
    transcript,
)
from crosscheck.audit.errata import finder as errata
from crosscheck.audit.errata.errata_texts import WORDS, add_erratum_text, load_notes
from crosscheck.audit.errata.erratum import (
    CLASSES,
    Effect,
    Erratum,
    ErratumPair,
    SimulatedErratum,
    compute_effect,
    run_model,
)
from crosscheck.audit.errata.lines import format_errata
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.models.arm.meshes import change_meshes
from crosscheck.models.errors import InputError
from crosscheck.models.files import read_toml
from crosscheck.models.loading import load_arm
from crosscheck.planning.plan import remove_backlash
from tests.arms import arm_of

ENTRIES = [
    *(("mass_matrix", row, column) for row, column in product(range(6), repeat=2)),
    *(("bias", row, 0) for row in range(6)),
    *(("force", row, 0) for row in range(6)),
]


def _corrupted(form: Form, matrix: str, row: int, column: int) -> Form:
    """One entry with a sign turned, or one appearing from nowhere."""
    changed = sp.Matrix(getattr(form, matrix))
    entry = changed[row, column]
    changed[row, column] = -entry if entry != 0 else form.v[2] * form.v[5]
    return replace(form, **{matrix: sp.ImmutableMatrix(changed)})


def _entries(printed: Form, derived: Form) -> set[tuple[str, int, int]]:
    found = entry_differences.find_entry_differences(printed, derived)
    return {(d.matrix, *entry) for d in found for entry in d.entries}


@pytest.mark.parametrize(("matrix", "row", "column"), ENTRIES)
@pytest.mark.parametrize("build_form", [build_energies_form, build_printed_form])
def test_a_corrupted_entry_adds_itself_and_no_other(build_form, matrix, row, column):
    """Clean equations have no errors, the printed ones their own."""
    known = _entries(build_form(), build_energies_form())
    assert (known == set()) == (build_form == build_energies_form)
    found = _entries(_corrupted(build_form(), matrix, row, column), build_energies_form())
    assert found == known | {(matrix, row, column)}


def test_correcting_every_difference_leaves_none():
    form = build_printed_form()
    for difference in entry_differences.find_entry_differences(form, build_energies_form()):
        form = entry_differences.replace_entries(form, build_energies_form(), difference)
    assert entry_differences.find_entry_differences(form, build_energies_form()) == []


def test_energies_and_bodies_differ_where_the_forms_do():
    """Adding what the energies leave out turns `energies` into `physical`."""
    form, chain = build_energies_form(), build_symbolic_chain([True, True])
    missing = sp.Add(*(found.missing_energy for found in energy.find_energy_differences()))
    mass = sp.Matrix(form.mass_matrix) + sp.hessian(missing, form.v)
    target = mass_matrix(build_mass_terms(build_bodies(chain), chain.angles[1:]), form.q)
    assert all(map(entry_differences.are_equal_entries, mass, target))


@pytest.mark.parametrize("equation", sorted(kinetic_energies()))
def test_a_lost_energy_is_reported_at_its_equation(equation, monkeypatch):
    known = {(d.where, d.body) for d in energy.find_energy_differences()}
    energies = kinetic_energies() | {equation: sp.S.Zero}
    monkeypatch.setattr(energy, "kinetic_energies", lambda: energies)
    found = {(d.where, d.body) for d in energy.find_energy_differences()}
    assert {where for where, _ in found - known} == {equation}
    assert known <= found


def test_an_energy_of_no_body_is_reported(monkeypatch):
    stray = sp.Symbol("m_stray", positive=True) * build_energies_form().v[2] ** 2
    energies = kinetic_energies()
    monkeypatch.setattr(
        energy, "kinetic_energies", lambda: energies | {"Eq. 16": energies["Eq. 16"] + stray}
    )
    assert ("Eq. 16", "no body") in {(d.where, d.body) for d in energy.find_energy_differences()}


def test_statement_errata_vanish_when_the_paper_is_put_right(labelled, monkeypatch):
    """Limits lie on the other side of what the rigid arm does; deviations make 30 mm."""
    numbered = (transcript.SymbolDefinition(f"s{n}", f"quantity {n}", "here") for n in range(5))
    for module, name, right in (
        (transcript, "INITIAL_VALUES", ("b", "b", "0", "b", "b", *["0"] * 7)),
        (transcript, "DEFINITIONS", tuple(numbered)),
        (transcript, "BACKLASHES_UM", (50.0, 100.0, 200.0, 300.0, 500.0)),
        (transcript, "TOOTH_ERRORS_UM", (0.8, 1.6, 3.2)),
        (transcript, "ENTRIES", tuple(transcript.MADE_OF)),
        (transcript, "DEVIATIONS_RAD", (0.015, 0.00643)),
        (statements, "CONSIDERABLE", 0.09),
        (statements, "NEARLY_ALWAYS", 0.5),
    ):
        monkeypatch.setattr(module, name, right)
    for errata_left in (
        statements.find_initial_value_errata(),
        statements.find_ambiguous_symbols(),
        statements.find_extrapolation_errata(),
        statements.find_unused_abbreviations(),
        statements.find_tip_errata(labelled),
        statements.find_overshoot_errata(labelled),
        statements.find_speed_errata(labelled),
    ):
        assert list(errata_left) == []


def test_two_errors_reach_the_tip_as_vectors(labelled):
    """The difference of two positions of the tip, by trigonometry; 1.5 % is the next order."""
    (erratum,) = statements.find_tip_errata(labelled)
    for bend, told_mm in ((0.0, "straight"), (math.pi / 2, "bent")):
        places = [
            np.array([math.cos(a) + 0.7 * math.cos(a + b), math.sin(a) + 0.7 * math.sin(a + b)])
            for a, b in ((0.0, bend), (0.02, bend + 0.01))
        ]
        apart_mm = 1e3 * float(np.linalg.norm(places[1] - places[0]))
        assert erratum.quoted[told_mm] == pytest.approx(apart_mm, rel=0.015)


def test_eq_10_gives_one_frequency_if_the_planet_counts_with_the_carrier(labelled):
    """Teeth that pass: 99 for each wheel, up to the sense (Willis)."""
    (erratum,) = auxiliary.find_gear_sense_errata(paper_stage(labelled))
    joint = paper_stage(labelled).joint
    turning = 1 - joint.ring_teeth / joint.planet_teeth  # the planet's own rate, with the carrier
    assert abs(turning - 1) * joint.planet_teeth == pytest.approx(joint.ring_teeth)
    assert erratum.quoted["sun"] == pytest.approx(99)
    assert erratum.quoted["ring"] == pytest.approx(-99)
    assert erratum.quoted["planet"] == pytest.approx((-turning - 1) * joint.planet_teeth)


def test_equation_errata_vanish_when_the_teeth_are_put_right(labelled):
    assert list(auxiliary.find_clearance_errata(paper_stage(remove_backlash(labelled)))) == []
    exact = change_meshes(
        labelled,
        lambda mesh: mesh.model_copy(
            update={
                "tooth_error_m": 0.0,
                "stiffness": mesh.planet_mesh(0).stiffness.model_copy(
                    update={"amplitude_N_per_m": 0.0}
                ),
            }
        ),
    )
    assert list(auxiliary.find_time_force_errata(paper_stage(exact))) == []


def test_abbreviations_without_use_are_found_through_others():
    (found,) = statements.find_unused_abbreviations()
    assert found.quoted == {"names": "M_ci and a_5"}


@pytest.fixture(scope="module")
def found(labelled) -> list[Erratum]:
    return errata.find_errata(labelled)


def test_every_erratum_has_an_id_of_its_own_and_words(found):
    assert len({erratum.id for erratum in found}) == len(found)
    for erratum in map(add_erratum_text, found):
        assert erratum.where
        assert erratum.printed
        assert erratum.derived
        assert "{" not in f"{erratum.printed}{erratum.derived}{erratum.remark}"


def test_all_words_are_of_errata_that_can_be_found(found):
    words = set(read_toml(WORDS))
    ids = {erratum.id for erratum in found}
    known = ids | {name.partition("-")[0] for name in ids}
    assert words - known == {"table-planet"}  # only where a planet's M is above its m


def test_errors_of_equations_have_effects_and_nothing_else_has(found):
    """Only these are quoted as a number of errors; one of them nobody ever simulated."""
    equations = {one.id for one in found if add_erratum_text(one).kind == "equation"}
    assert equations - {one.id for one in found if one.trial} == {"eq15-clearance"}
    assert all(one.id in equations for one in found if one.trial)
    read = load_notes().misprints
    assert "equation" not in {one.kind for one in read}
    assert not {one.id for one in read} & {one.id for one in found}


def test_an_energy_is_printed_as_the_paper_has_it():
    """Eq. 18: three halves of I_p2 times the square of the planet's own rate."""
    (one,) = (
        d for d in energy.find_energy_differences() if (d.where, d.body) == ("Eq. 18", "planets 2")
    )
    assert str(energy.as_printed(one.printed)) == "3*I_p2*dtheta_p2**2/2"
    assert str(energy.as_printed(one.derived)) == "3*I_p2*(dtheta_1 - dtheta_p2)**2/2"


def test_an_impulse_hardly_sees_a_shifted_impact_and_a_force_sees_all_of_it():
    """A pulse of 1 N and 10 ms, 0.1 ms later: 1 N, and 1e-4 N s."""
    time = np.arange(2001) * 1e-4

    def run(begin: float) -> xr.Dataset:
        force = ((time >= begin) & (time < begin + 0.01)).astype(float)[:, None]
        values = dict.fromkeys(("F_sp", "F_pr", "theta"), (("time", "mesh"), force))
        return xr.Dataset(values, {"time": time})

    pulses = {"printed": run(0.05), "right": run(0.0501)}
    trial = ErratumPair("printed", "right")  # type: ignore[arg-type]  # names of runs
    effect = compute_effect(trial, None, lambda side, scenario: pulses[side])  # type: ignore[arg-type]
    assert effect.mesh_force_N == 1.0
    assert effect.impulse_N_s == pytest.approx(1e-4)


def test_decay_is_that_of_the_damped_vibration(labelled):
    """With light damping half the loss of each mode is its share of the dampers' work."""
    stage = paper_stage(labelled)
    slow, quick = (statements.decay_s(stage, zeta) for zeta in (1e-4, 1e-3))
    # The first order in zeta; the next is of the order of zeta^2.
    assert slow / quick == pytest.approx(10, rel=1e-5)
    # physics.md: the lower mode, 1709.9 Hz, has the ratio 0.0425 at zeta 0.05.
    assert 1e-3 * quick == pytest.approx(
        1e-3 * math.log(10) / (0.0425 / 0.05 * 1e-3 * 2 * math.pi * 1709.9), rel=2e-3
    )


def test_a_planted_loss_is_seen_where_it_is_gross_and_not_in_the_meshes():
    """M_33 left out stops the arm's own inertia; M_12 couples two meshes alone."""
    clean = build_energies_form()
    gone = planted_faults.remove_entry(clean, "mass_matrix", (2, 5)).mass_matrix
    assert gone[2, 5] == gone[5, 2] == 0
    kept = list(planted_faults.nonzero_entries(clean))
    assert ("mass_matrix", (0, 1)) in kept
    assert ("mass_matrix", (1, 0)) not in kept
    plants = [
        planted_faults.EntryOmission("mass_matrix", (0, 1), 1e-8),
        planted_faults.EntryOmission("mass_matrix", (2, 5), 0.7),
        planted_faults.EntryOmission("mass_matrix", (0, 0), None),
    ]
    assert planted_faults.detectable_share(plants) == pytest.approx(2 / 3)


def test_only_the_labelled_reading_has_a_sun_heavier_outside_than_its_rim():
    found = {
        name: [e.id for e in statements.find_mass_errata(paper_stage(load_arm(f"paper-{name}")))]
        for name in ("labelled", "swapped")
    }
    assert found == {"labelled": ["table-sun"], "swapped": []}


def test_other_arms_than_the_papers_are_refused():
    with pytest.raises(InputError, match="two joints with three planets"):
        errata.find_errata(arm_of(3))


def test_a_stage_whose_meshes_differ_is_refused(labelled):
    mesh = labelled.joints[0].ring_mesh.model_copy(update={"backlash_m": 1e-5})
    joint = labelled.joints[0].model_copy(update={"ring_mesh": mesh})
    unlike = labelled.model_copy(update={"joints": (joint, labelled.joints[1])})
    with pytest.raises(InputError, match=r"joints\[0\].ring_mesh: must be as sun_mesh"):
        paper_stage(unlike)
    assert paper_stage(unlike, 1).backlash_m == 5e-5


@pytest.mark.parametrize(("place", "field"), [(0, "sun_mesh.stiffness"), (1, "joints[1].kind")])
def test_a_stage_of_another_kind_is_refused(place, field):
    with pytest.raises(InputError, match=rf"{re.escape(field)} = '\w+': must be"):
        paper_stage(load_arm("direct-between"), place)


def test_every_simulated_effect_is_resolved(found):
    """Each error of an equation changes the mesh force in a PD run by more than rounding."""
    torque, pd = errata.load_effect_scenarios()
    run = cache(run_model)  # many trials share a side
    short = pd.model_copy(update={"duration_s": 0.05})
    for erratum in found:
        if erratum.trial is not None:
            effect = compute_effect(erratum.trial, short, run)
            # 1e-9 N: hundredfold the rounding of forces of 1e4 N.
            assert effect.mesh_force_N > 1e-9, erratum.id
    assert torque.duration_s == errata.EFFECT_S


def test_the_terminal_has_the_count_first_and_formulas_whole_in_80_columns():
    right = "J_r2*dtheta_1**2/2 + 3*I_p2*(dtheta_1 - dtheta_p2)**2/2 + M_s2*r_s2**2*dtheta_1**2/2"
    effect = Effect(theta_rad=2.1e-3, mesh_force_N=0.5, impulse_N_s=1.25e-3)
    one = Erratum("e", where="Eq. 18", printed="0", derived=right, size=5000.0, unit="N [rad]")
    read = replace(one, id="n", kind="notation", where="Fig. 5", remark="word " * 40)
    found = [SimulatedErratum(one, {"pd": effect}), SimulatedErratum(read, {})]
    lines = list(format_errata(found, "mine", CLASSES[:1]))
    assert lines[0].startswith("1 error of equations (arm mine)")
    assert max(map(len, [*lines, *format_errata(found, "mine", CLASSES)])) < 80
    words = " ".join(" ".join(lines).split())
    assert right in words
    assert "size 5000 N [rad]" in words
    assert "pd: angle 0.0021 rad, impulse of a mesh 0.0013 N s" in words
    assert "Fig. 5" not in words
    whole = " ".join(" ".join(format_errata(found, "mine", CLASSES)).split())
    for note in load_notes().contradictions:
        assert f"{note.first}: {note.first_says}" in whole
        assert note.first_says not in words
    for gap in load_notes().gaps:
        assert f"{gap.quantity} (needed for {gap.needed_for}) here {gap.here}" in whole
    assert "Fig. 5" in list(format_errata(found, "mine", CLASSES))
