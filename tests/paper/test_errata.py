"""The errata finder finds what is wrong, and nothing else."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import product

import pytest
import sympy as sp

from analytic.energies import energies_form, kinetic_energies
from analytic.forms import Form
from analytic.physical import physical_form
from analytic.printed import printed_form
from crosscheck.paper.errata import auxiliary, compare, energy, transcript
from crosscheck.paper.errata import finder as errata
from crosscheck.paper.errata.erratum import effect_of
from crosscheck.paper.stage import paper_stage, without_backlash
from models.errors import InputError
from models.loading import load_arm
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
    found = compare.differences(printed, derived)
    return {(d.matrix, *entry) for d in found for entry in d.entries}


@pytest.mark.parametrize(("matrix", "row", "column"), ENTRIES)
def test_a_corrupted_entry_is_reported_and_no_other(matrix, row, column):
    clean = energies_form()
    assert _entries(_corrupted(clean, matrix, row, column), clean) == {(matrix, row, column)}


@pytest.mark.parametrize(("matrix", "row", "column"), ENTRIES)
def test_a_corrupted_entry_adds_itself_to_the_papers_own_slips(matrix, row, column):
    known = _entries(printed_form(), energies_form())
    found = _entries(_corrupted(printed_form(), matrix, row, column), energies_form())
    assert found == known | {(matrix, row, column)}


def test_correcting_every_difference_leaves_none():
    form = printed_form()
    for difference in compare.differences(form, energies_form()):
        form = compare.corrected(form, energies_form(), difference)
    assert compare.differences(form, energies_form()) == []


def test_energies_and_bodies_differ_where_the_forms_do():
    """Adding what the energies leave out turns `energies` into `physical`."""
    missing = sp.Add(*(difference.missing for difference in energy.differences()))
    mass = sp.Matrix(energies_form().mass_matrix) + sp.hessian(missing, energies_form().v)
    target = physical_form(2).mass_matrix
    gaps = [compare.same(one, other) for one, other in zip(mass, target, strict=True)]
    assert all(gaps)


@pytest.mark.parametrize("equation", sorted(kinetic_energies()))
def test_a_lost_energy_is_reported_at_its_equation(equation, monkeypatch):
    known = {(d.where, d.body) for d in energy.differences()}
    energies = kinetic_energies() | {equation: sp.S.Zero}
    monkeypatch.setattr(energy, "kinetic_energies", lambda: energies)
    found = {(d.where, d.body) for d in energy.differences()}
    assert {where for where, _ in found - known} == {equation}
    assert known <= found


def test_an_energy_of_no_body_is_reported(monkeypatch):
    stray = sp.Symbol("m_stray", positive=True) * energies_form().v[2] ** 2
    energies = kinetic_energies()
    monkeypatch.setattr(
        energy, "kinetic_energies", lambda: energies | {"Eq. 16": energies["Eq. 16"] + stray}
    )
    assert ("Eq. 16", "no body") in {(d.where, d.body) for d in energy.differences()}


def test_auxiliary_errata_vanish_when_the_paper_is_put_right(labelled, monkeypatch):
    twelve = ("b", "b", "0", "b", "b", "0", *["0"] * 6)
    monkeypatch.setattr(transcript, "INITIAL_VALUES", twelve)
    assert list(auxiliary.initial_values()) == []
    unique = tuple(
        transcript.Definition(f"s{number}", f"quantity {number}", "here") for number in range(5)
    )
    monkeypatch.setattr(transcript, "DEFINITIONS", unique)
    assert list(auxiliary.symbols_used_twice()) == []
    assert list(auxiliary.quantities_with_two_symbols()) == []
    assert list(auxiliary.force_without_clearance(without_backlash(labelled))) == []


def test_only_the_labelled_reading_has_a_sun_heavier_outside_than_its_rim():
    found = {
        name: [e.where for e in auxiliary.masses_and_inertias(load_arm(f"paper-{name}"))]
        for name in ("labelled", "swapped")
    }
    assert found == {"labelled": ["Table I, sun"], "swapped": []}


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


def test_every_simulated_effect_is_resolved(labelled):
    """Each equation's slip moves the mesh force in a PD run by more than rounding."""
    torque, pd = errata.effect_scenarios()
    short = pd.model_copy(update={"duration_s": 0.05})
    for erratum in errata.find_errata(labelled):
        if erratum.trial is not None:
            effect = effect_of(erratum.trial, short)
            # 1e-9 N: hundredfold the rounding of forces of 1e4 N.
            assert effect.mesh_force_N > 1e-9, erratum.where
    assert torque.duration_s == errata.EFFECT_S
