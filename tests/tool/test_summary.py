"""Results, arms and models print themselves; a notebook shows results with their heat map."""

import json
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from syrupy.assertion import SnapshotAssertion

import crosscheck
from crosscheck.findings import Agreement, EntryDifferences
from crosscheck.models.arm.arm import Link
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.report import html
from crosscheck.report.heat_map import make_entry_maps, make_heat_map
from crosscheck.report.plots.charts import Pictures
from crosscheck.report.rendering import add_contents, capitalize_sentence, keep_together
from crosscheck.report.summary import summarize_agreement
from crosscheck.run import CrossCheck
from crosscheck.trial.changes.arms.dependence import IgnoredNumber
from crosscheck.trial.changes.arms.term_words import describe_point_masses, describe_unfollowed
from tests.baselines.short import green, invented_check, red
from tests.trial.trial_views import kept_arm

NAMES = ("x_sp1", "theta_1")
ENTRIES = [
    EntryDifferences(
        "mass_matrix", model, ("exudyn:tree",), NAMES, ((0.0, wrong), (wrong, 0.0)), 1e-10
    )
    for model, wrong in (("analytic:printed", 0.0127), ("analytic:physical", 1e-14))
]


def test_a_cell_is_shaded_by_the_decades_of_its_difference_once_it_differs():
    row = (0.0, 1e-10, 1.1e-10, 9e-7, 1e-6, 1e-4, 9.9e-3, 0.01, 3.0, np.nan)
    found = make_heat_map("M", [str(value) for value in row], np.tile(row, (10, 1)), 1e-10)
    assert [cell.shade for cell in found.cells[0]] == [0, 0, 1, 1, 2, 3, 3, 4, 4, 4]
    depths = [cell.depth for cell in found.cells[0]]
    assert depths == [None, None, 0, 0, 0, 33, 67, 67, 100, 100]  # no step at 1 %
    assert found.described == "M: 80 of 100 entries differ"


def test_sections_of_a_page_have_one_list_of_links():
    page = add_contents('<h2 id="own">A</h2>\n' + "<h2>A</h2>\n" * 2)
    counts = [page.count(each) for each in ('id="contents"', '"#own">A<', '"#section-2">A<')]
    assert counts == [1, 1, 1]


def test_of_two_forms_as_printed_the_last_is_drawn_beside_the_corrected_one():
    """The other form is the printed energies', which has their errors alone."""
    other = replace(ENTRIES[0], model="analytic:energies", relative=((0.5, 0.5), (0.5, 0.5)))
    maps = make_entry_maps([other, *ENTRIES])
    assert [each.title for each in maps] == ["mass matrix, as printed", "mass matrix, corrected"]
    assert [[cell.text for cell in each.cells[0]] for each in maps] == [["✓", "1.3 %"], ["✓", "✓"]]


@pytest.mark.parametrize(("count", "is_wide"), [(8, False), (9, True)])
def test_names_of_more_than_eight_columns_are_written_upwards(count, is_wide):
    assert make_heat_map("M", "b" * count, np.zeros((count, count)), 0.0).is_wide is is_wide


def ignored(name, value, *parts, **goes_with):
    return IgnoredNumber(name, value, parts, goes_with)


UNFOLLOWED = {
    "one": [ignored("g", 9.81, "force", "mass_matrix")],
    "two": [ignored("g", 9.81, "force"), ignored("m_2", 0.123456789, "force")],
    "none that has any": [ignored("m_p", 0.0)],
    "one that is made of others": [
        *(ignored("a", 0.0), ignored("d", 2.0, L_1=1, L_2=-1), ignored("b", 0.0))
    ],
}


@pytest.mark.parametrize("name", UNFOLLOWED)
def test_numbers_that_equations_do_not_follow_are_reported_in_one_note(
    name: str, snapshot: SnapshotAssertion
):
    assert describe_unfollowed(UNFOLLOWED[name]) == snapshot


def test_a_number_in_a_wrong_part_may_be_the_error():
    said = describe_unfollowed(UNFOLLOWED["two"], {"force"})
    assert said.endswith("g = 9.81, m_2 = 0.123457: are they missing or hard-coded?")
    assert "missing" in describe_unfollowed(UNFOLLOWED["two"], {"force"}, {"g"})
    assert "missing" not in describe_unfollowed(UNFOLLOWED["two"], {"force"}, {"g", "m_2"})
    assert describe_unfollowed(UNFOLLOWED["two"], {"bias"}).endswith("with your values.")


def test_many_numbers_are_counted_and_all_of_the_file_are_said_to_be():
    six = [ignored(f"m_{place}", 1.5, "force") for place in range(6)]
    names = {each.name for each in six}
    assert "the file's m_0 = 1.5, m_1 = 1.5" in describe_unfollowed(six, in_file=names | {"g"})
    assert "m_4 = 1.5 and 1 more: are" in describe_unfollowed(six)
    every = "Your force does not change with any of the file's numbers: are they"
    assert describe_unfollowed(six, in_file=names).startswith(every)
    partly = [*six[1:], replace(six[0], partly=True)]
    assert "and 1 more" in describe_unfollowed(partly, in_file=names)


def test_point_masses_are_named():
    assert "have no I_1" in describe_point_masses(["I_1"])


def test_an_agreement_has_a_row_for_each_finding():
    table = Agreement([green(), red()]).to_dataframe()
    assert list(table.verdict) == ["agree", "differ"]
    assert table.measured[1] == red().measured
    assert "wrong M" in "".join(summarize_agreement(Agreement([green()], entries=ENTRIES)))


@pytest.mark.parametrize("mechanism", ["probe", "sliding"])
def test_what_is_asked_of_a_cross_check_is_handed_on(mechanism, labelled, monkeypatch):
    asked: list[tuple[CrossCheckRequest, int]] = []

    def note(request: CrossCheckRequest, jobs: int) -> CrossCheck:
        asked.append((request, jobs))
        return invented_check(labelled)

    monkeypatch.setattr("crosscheck.run.run_cross_check", note)
    is_arm = mechanism == "probe"
    settings: dict[str, Any] = {"scenarios": ["constant-torque"]} if is_arm else {}
    crosscheck.check(mechanism, quick=True, jobs=3, seed=7, **settings)
    ((request, jobs),) = asked
    assert (request.mechanism.name, jobs) == (mechanism, 3)
    assert (request.quick, request.seed) == (True, 7)
    assert [each.name for each in request.scenarios] == ["constant-torque"] * is_arm
    assert bool(request.arm_file_json) == is_arm


def test_a_trial_writes_what_the_command_writes(tmp_path):
    kept_arm().write_report(tmp_path)
    assert "<html" in (tmp_path / "trial.html").read_text()
    assert json.loads((tmp_path / "trial.json").read_text())["wrong"]


def test_labels_of_a_notebooks_maps_are_level_and_have_room():
    shown = kept_arm()._repr_html_()
    tables, level = shown.count("<table"), shown.count("vertical-align:top")
    labels, padded = shown.count("<th"), len(re.findall("<th [^>]*padding", shown))
    assert (level, padded) == (tables, labels)
    assert labels


def test_a_cross_check_writes_what_the_command_writes(labelled, tmp_path, monkeypatch):
    (run,) = (invented := invented_check(labelled)).runs.values()
    other = replace(next(iter(invented.runs)), model="exudyn:tree")
    invented = replace(invented, runs={**invented.runs, other: run.copy()})
    monkeypatch.setattr("crosscheck.run.run_cross_check", lambda request, jobs: invented)
    drawn = list[object]()
    monkeypatch.setattr(html, "draw_pictures", lambda runs: drawn.append(runs) or Pictures({}))
    crosscheck.check(labelled).write_report(tmp_path)
    assert drawn == [invented.runs]
    assert "Cross-check of paper-labelled" in (tmp_path / "index.html").read_text()
    assert len(json.loads((tmp_path / "agreement.json").read_text())["findings"]) == 1


def test_a_link_has_mass_and_inertia_however_it_is_stated():
    rod = Link(length_m=2.0, com_m=0.9, cross_section_m2=0.01, density_kg_per_m3=300.0)
    assert (rod.mass, rod.inertia) == pytest.approx((6.0, 2.0))
    body = Link(length_m=2.0, com_m=0.9, mass_kg=5.0, inertia_kg_m2=0.0)
    assert (body.mass, body.inertia) == (5.0, 0.0)


@pytest.mark.parametrize("name", ["analytic:coupled", "analytic:physical"])
def test_the_derivation_works_a_links_mass_out_by_itself(name, labelled, monkeypatch):
    """The engines read the arm as a robot, in which masses are numbers."""

    def refuse(link: Link) -> float:
        raise AssertionError("a link's mass is read")

    scenario = crosscheck.load_scenario("pd")
    for quantity in ("mass", "inertia"):
        monkeypatch.setattr(Link, quantity, property(refuse))
    model = crosscheck.build(name, labelled, scenario)
    assert np.isfinite(model.mass_matrix(np.zeros(len(model.coordinates)))).all()


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("the same by another edit", "The same by another edit"),
        *(
            (each, each)
            for each in ("bias[a] is wrong", "b3.py:5: f", "pd-motion: to 1", "M is", "")
        ),
    ],
)
def test_a_sentence_of_a_page_begins_with_a_capital_but_no_name_does(text, shown):
    assert capitalize_sentence(text) == shown


def test_no_line_ends_within_a_number_with_its_unit_or_a_minus_with_its_operand():
    said = keep_together("-m2 * (a - sin(q)) & c-d, --out -3; 1.3 ± 0.1 kg, 1e-3 m_p, 69 %, 2 more")
    wrapped = re.findall(r'<span class="unsplit">(.*?)</span>', said)
    assert wrapped == ["-m2", "- sin(q", "-3", "1.3 ± 0.1 kg", "69 %"]
    assert "&amp; c-d, --out" in said
