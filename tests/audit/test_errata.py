"""The errata finder finds what is wrong, and nothing else."""

import json
import re
from dataclasses import asdict, replace
from functools import cache
from itertools import product
from operator import call

import numpy as np
import pytest
import sympy as sp
import xarray as xr
from pydantic import TypeAdapter
from syrupy.assertion import SnapshotAssertion

from crosscheck.analytic.derivation.bodies import build_bodies
from crosscheck.analytic.derivation.forms import Form, mass_matrix
from crosscheck.analytic.derivation.lagrange import build_mass_terms
from crosscheck.analytic.derivation.symbols import build_symbolic_chain
from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.paper.energies import build_energies_form, kinetic_energies
from crosscheck.analytic.paper.kinematics import gear_angles
from crosscheck.analytic.paper.mesh_force import dead_zone_tanh
from crosscheck.analytic.paper.mesh_frequency import meshing_frequency
from crosscheck.analytic.paper.model import PrintedModel
from crosscheck.analytic.paper.printed import build_printed_form
from crosscheck.audit.errata import differences, printed_equations
from crosscheck.audit.errata import finder as errata
from crosscheck.audit.errata.differences import find_energy_differences, find_entry_differences
from crosscheck.audit.errata.errata_texts import (
    build_record,
    format_sections,
    list_sections,
    load_notes,
)
from crosscheck.audit.errata.erratum import Effect, Erratum, compute_effect, tex
from crosscheck.audit.measures.stage import paper_stage
from crosscheck.audit.statics.statics import tip_shift
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.planning.plan import remove_backlash
from tests.arms import arm_of
from tests.loops import require_items
from tests.views.plain import mask_numbers

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
    found = find_entry_differences(printed, derived)
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
    form, derived = build_printed_form(), build_energies_form()
    for difference in require_items(find_entry_differences(form, derived)):
        place, matrix = difference.entries[0], difference.matrix
        off = getattr(form, matrix)[place] - getattr(derived, matrix)[place]
        assert sp.expand(difference.printed - difference.derived - off) == 0
        form = differences.replace_entries(form, derived, difference)
    assert find_entry_differences(form, build_energies_form()) == []


def test_energies_and_bodies_differ_where_the_forms_do():
    """Adding what the energies leave out turns `energies` into `physical`."""
    form, chain = build_energies_form(), build_symbolic_chain([True, True])
    missing = sp.Add(*(found.missing_energy for found in find_energy_differences()))
    mass = sp.Matrix(form.mass_matrix) + sp.hessian(missing, form.v)
    target = mass_matrix(build_mass_terms(build_bodies(chain), chain.angles[1:]), form.q)
    assert all(map(differences.are_equal_entries, mass, target))


@pytest.mark.parametrize("equation", sorted(kinetic_energies()))
def test_a_lost_energy_is_reported_at_its_equation(equation, monkeypatch):
    known = {(d.where, d.body) for d in find_energy_differences()}
    energies = kinetic_energies() | {equation: sp.S.Zero}
    monkeypatch.setattr(differences, "kinetic_energies", lambda: energies)
    found = {(d.where, d.body) for d in find_energy_differences()}
    assert {where for where, _ in found - known} == {equation}
    assert known <= found


def test_an_energy_of_no_body_is_reported(monkeypatch):
    stray = sp.Symbol("m_stray", positive=True) * build_energies_form().v[2] ** 2
    energies = kinetic_energies()
    monkeypatch.setattr(
        differences, "kinetic_energies", lambda: energies | {"Eq. 16": energies["Eq. 16"] + stray}
    )
    assert ("Eq. 16", "no body") in {(d.where, d.body) for d in find_energy_differences()}


@pytest.fixture(scope="module")
def found(labelled) -> list[Erratum]:
    return errata.find_errata(labelled)


def test_every_entry_has_an_id_of_its_own_and_words(found):
    """Only errors of equations are computed, with an effect; one of them nobody ever simulated."""
    read = load_notes().entries
    assert len({one.id for one in (*found, *read)}) == len(found) + len(read)
    for erratum in (*found, *read):
        assert erratum.where
        assert erratum.printed
        assert erratum.derived
        assert (erratum.kind == "equation") == (erratum in found)
    assert {one.id for one in found if one.trial is None} == {"eq15-clearance"}
    assert all(one.trial is None or one.trial[0] != one.trial[1] for one in found)


def test_the_drawn_formulas_are_those_of_the_text(found):
    """Each side's TeX is its text's, wherever that text is a formula of SymPy's."""
    drawn = [
        (getattr(one, side).removeprefix("... "), getattr(one, f"{side}_tex"))
        for one in found
        for side in ("printed", "derived")
        if re.fullmatch(r"[\w+*/(). -]+", getattr(one, side))
        and not re.search(r"\w \w", getattr(one, side))  # as people write it
    ]
    for text, drawing in require_items(drawn):
        names = {name: sp.Symbol(name) for name in re.findall(r"[A-Za-z]\w*", text)}
        functions = {"sin": sp.sin, "cos": sp.cos, "tanh": sp.tanh}
        assert drawing == tex(sp.sympify(text, names | functions)), text


@pytest.mark.parametrize("every", [False, True])
def test_the_terminal_has_the_count_first_and_formulas_whole_in_80_columns(
    found, every, snapshot: SnapshotAssertion
):
    """Of the errors as they are found, before anything is simulated."""
    lines = list(format_sections(list_sections("paper-labelled", found), every))
    assert max(map(len, lines)) < 80
    assert mask_numbers("\n".join(lines)) == snapshot


def test_the_sizes_of_each_entry_of_m_add_up_to_what_a_cross_check_finds(found, labelled):
    """Of both models at theta = 0, but for the ring, whose inertia the arm's file has as 0.

    That is of its mass at its base radius.
    """
    summed = np.zeros((6, 6))
    for one in found:
        for unit, size in {one.unit: one.size, **one.others}.items():
            if place := re.fullmatch(r"[kgm^2 ]+ in M_(\d)(\d) = M\[(\w+), (\w+)\]", unit):
                row, column = int(place[1]) - 1, int(place[2]) - 1
                assert place.groups()[2:] == (errata.LAYOUT.names[row], errata.LAYOUT.names[column])
                summed[row, column] += size * (one.id != "eq18-ring-2")
    scenario = load_scenario("pd")
    models = PhysicalModel(labelled, scenario), PrintedModel(labelled, scenario)
    right, printed = (np.triu(model.mass_matrix(np.zeros(6))) for model in models)
    assert np.count_nonzero(summed) == 4
    assert summed == pytest.approx(right - printed, rel=1e-9, abs=1e-12)
    (ring,) = (one.size for one in found if one.id == "eq18-ring-2")
    joint = labelled.joints[1]
    radius = joint.module_m / 2 * np.cos(np.radians(joint.pressure_angle_deg)) * joint.ring_teeth
    assert ring == pytest.approx(joint.ring_mass_kg * radius**2, rel=1e-12)


def test_the_clearance_is_an_error_where_there_is_one(labelled):
    assert list(errata.find_clearance_errata(paper_stage(remove_backlash(labelled)))) == []


def test_numbers_of_what_is_read_are_those_of_equations_and_table(labelled):
    """Eq. 10's three rates for one mesh; Eq. 6's pull; M and m of the sun; the tip's way."""
    words = {one.id: f"{one.printed} {one.derived} {one.remark}" for one in load_notes().entries}
    stage = paper_stage(labelled)
    joint, geometry = stage.joint, stage.geometry
    sun, planet = gear_angles(0.0, 0.0, 1.0, geometry.r_s, geometry.r_p, geometry.r_cp)
    rates = [
        meshing_frequency(rate, 1.0, teeth)
        for rate, teeth in (
            (sun, joint.sun_teeth),
            (planet, joint.planet_teeth),
            (0.0, joint.ring_teeth),
        )
    ]
    assert "{:.0f}, {:.0f} and {:.0f}".format(*rates) in words["eq10-sense"]
    outside = stage.backlash_m - np.linspace(0, 1e-7, 100001)
    pull = -1e8 * dead_zone_tanh(outside, stage.backlash_m, 1e8).min()
    assert f"{pull:.2g} k / sigma" in words["eq6-attracts"]
    assert (
        f"M = {stage.sun_equivalent_mass_kg:g} kg, m = {joint.sun_mass_kg:g} kg"
        in (words["table-sun"])
    )
    assert f"{tip_shift(labelled, 0.0):.3f} m" in words["thirty-millimetres"]
    assert tip_shift(labelled, 90.0) == pytest.approx(0.03, rel=0.05)  # about 30 mm


def test_an_energy_is_printed_as_the_paper_has_it():
    """Eq. 18: three halves of I_p2 times the square of the planet's own rate."""
    (one,) = (d for d in find_energy_differences() if (d.where, d.body) == ("Eq. 18", "planets 2"))
    assert str(differences.as_printed(one.printed)) == "3*I_p2*dtheta_p2**2/2"
    assert str(differences.as_printed(one.derived)) == "3*I_p2*(dtheta_1 - dtheta_p2)**2/2"


def test_an_impulse_hardly_sees_a_shifted_impact_and_a_force_sees_all_of_it():
    """A pulse of 1 N and 10 ms, 0.1 ms later: 1 N, and 1e-4 N s."""
    time = np.arange(2001) * 1e-4

    def run(begin: float) -> xr.Dataset:
        force = ((time >= begin) & (time < begin + 0.01)).astype(float)[:, None]
        values = dict.fromkeys(("F_sp", "F_pr", "theta"), (("time", "mesh"), force))
        return xr.Dataset(values, {"time": time})

    pulses = {"printed": run(0.05), "right": run(0.0501)}
    trial = ("printed", "right")  # type: ignore[arg-type]  # names of runs
    effect = compute_effect(trial, None, lambda side, scenario: pulses[side])  # type: ignore[arg-type]
    assert effect.mesh_force_N == 1.0
    assert effect.impulse_N_s == pytest.approx(1e-4)


def test_a_planted_loss_is_seen_where_it_is_gross_and_not_in_the_meshes():
    """M_33 left out stops the arm's own inertia; M_12 couples two meshes alone."""
    clean = build_energies_form()
    gone = printed_equations.remove_entry(clean, "mass_matrix", (2, 5)).mass_matrix
    assert gone[2, 5] == gone[5, 2] == 0
    kept = list(printed_equations.nonzero_entries(clean))
    assert ("mass_matrix", (0, 1)) in kept
    assert ("mass_matrix", (1, 0)) not in kept
    assert printed_equations.detectable_share([1e-8, 0.7, None]) == pytest.approx(2 / 3)


def test_a_stage_whose_meshes_differ_is_refused(labelled):
    mesh = labelled.joints[0].ring_mesh.model_copy(update={"backlash_m": 1e-5})
    joint = labelled.joints[0].model_copy(update={"ring_mesh": mesh})
    unlike = labelled.model_copy(update={"joints": (joint, labelled.joints[1])})
    with pytest.raises(InputError, match=r"joints\[0\].ring_mesh: must be as sun_mesh"):
        paper_stage(unlike)
    assert paper_stage(unlike, 1).backlash_m == 5e-5


def test_other_arms_than_the_papers_and_stages_of_another_kind_are_refused():
    with pytest.raises(InputError, match="two joints with three equal planets"):
        errata.find_errata(arm_of(3))
    for place, field in ((0, "sun_mesh.stiffness"), (1, "joints[1].kind")):
        with pytest.raises(InputError, match=rf"{re.escape(field)} = '\w+': must be"):
            paper_stage(load_arm("direct-between"), place)


def test_every_simulated_effect_is_resolved(found):
    """Each error of an equation changes the mesh force in a PD run by more than rounding."""
    torque, pd = errata.load_effect_scenarios()
    run = cache(call)  # many trials share a side
    short = pd.model_copy(update={"duration_s": 0.05})
    for erratum in found:
        if erratum.trial is not None:
            effect = compute_effect(erratum.trial, short, run)
            # 1e-9 N: hundredfold the rounding of forces of 1e4 N.
            assert effect.mesh_force_N > 1e-9, erratum.id
    assert torque.duration_s == errata.EFFECT_S


def test_an_erratum_is_kept_as_it_was_without_trial_and_infinite_size(labelled, monkeypatch):
    given = Erratum("eq1", where="Eq. 1", printed="a", derived="b", size=np.inf, trial=(abs, abs))
    effect = Effect(1e-3, 5.0, 0.1)
    monkeypatch.setattr(errata, "find_errata", lambda arm: [given])
    monkeypatch.setattr(errata, "compute_effect", lambda trial, scenario, run: effect)
    (tried,) = errata.simulate_errata(labelled, lambda where: None)
    assert (tried.trial, tried.size) == (None, None)
    kept = json.loads(json.dumps(asdict(tried), allow_nan=False))
    assert TypeAdapter(Erratum).validate_python(kept) == tried
    assert build_record("mine", tried)["effects"]["pd"]["mesh_force_N"] == 5.0
