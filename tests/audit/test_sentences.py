"""The table of the paper's sentences is whole: none left out, none that leads nowhere."""

import pytest

from crosscheck.audit.claims.catalogue import BY_ID, SENTENCES
from crosscheck.audit.errata.errata_texts import load_notes
from crosscheck.audit.errata.finder import find_errata
from crosscheck.audit.judging.sentences import Sentence, load_sentences
from crosscheck.models.loading import load_arm
from tests.loops import require_items

# Counted in the paper, captions and the table among them.
OF_THE_PAPER = {
    "Abstract": 6,
    "1": 40,
    "2": 20,
    "2.1": 20,
    "2.2": 16,
    "2.3": 9,
    "2.4": 27,
    "3": 11,
    "3.1": 18,
    "3.2": 35,
    "4": 4,
    "4.1": 29,
    "4.2": 23,
    "5": 8,
}


@pytest.fixture(scope="module")
def table() -> tuple[Sentence, ...]:
    return load_sentences(SENTENCES)


def test_the_table_has_every_sentence_in_order_by_its_first_words(table):
    numbers = [(section, at + 1) for section, count in OF_THE_PAPER.items() for at in range(count)]
    assert [(one.section, one.number) for one in table] == numbers
    assert all(1 <= len(one.begins.split()) <= 4 for one in table)


def test_every_claim_is_named_by_a_sentence_and_every_name_is_a_claim(table):
    assert {name for one in table for name in one.claims} == set(BY_ID)


def test_every_item_of_the_errata_sheet_is_named_by_a_sentence_and_no_other(table):
    noted = load_notes()
    known = {erratum.id for erratum in find_errata(load_arm("paper-labelled"))}
    known |= {entry.id for entry in noted.entries}
    known |= {note["id"] for note in (*noted.contradictions, *noted.gaps)}
    assert {name for one in table for name in one.errata} == known


# Errors and statements of the sheet that deny no claim, each with the reason.
DENY_NONE = {
    "eq6-attracts": "grants claim 2.1-09 and adds what the text leaves out",
    "eq8-eq14-one-phase": "the text asserts nothing of gamma",
    "drive-root": "a guess at the torque that was meant",
    "table-ring": "which of two quantities a number is",
    "rod-or-bar": "which body is meant",
    "between-50-and-500": "not shown by the paper; claim 4.1-27 asks whether it is so",
    "below-1-um": "not shown by the paper; claim 4.2-06 asks whether it is so",
    "influence-avoided": "of models in general",
    "suitable-for-long-strokes": "of the model's use",
    "shorter-because": "the reason, and not the fact, which is claim 4.1-10",
    "error-for-precision": "of manufacture",
    "accumulates-or-erased": "a conclusion that does not follow",
}


def test_what_the_sheet_denies_is_a_claim_of_the_same_sentence(table):
    """So a claim that holds cannot stand beside an entry that says it is wrong unnoticed."""
    read = [entry for entry in load_notes().entries if entry.kind != "notation"]
    sheet = [*find_errata(load_arm("paper-labelled")), *read]
    assert {one.id for one in sheet if not one.denies} == set(DENY_NONE)
    for one in require_items(one for one in sheet if one.denies):
        named = [sentence for sentence in table if one.id in sentence.errata]
        assert any(set(one.denies) <= set(sentence.claims) for sentence in named), one.id


@pytest.mark.parametrize(
    "leads",
    [{}, {"claims": ("2-01",), "none": "caption"}, {"errata": ("step",), "none": "caption"}],
)
def test_a_sentence_leads_somewhere_or_says_why_not(leads):
    with pytest.raises(ValueError, match="or else a reason for none"):
        Sentence("2", 1, "A typical", **leads)
