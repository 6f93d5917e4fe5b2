"""No model that answers wrongly passes: every method x every model x every kind of wrong answer."""

import pytest

from crosscheck.findings import Agreement
from crosscheck.models.interface import Model
from crosscheck.registry import MODELS, load_model_class, model_names
from crosscheck.report.junit import format_junit
from tests.arms import PAPER
from tests.brief import brief, perform_here
from tests.faults.mutations import BRIEF_S, Campaign, Mutant, mutants
from tests.loops import require_items

pytestmark = pytest.mark.slow


def test_every_wrong_answer_of_a_model_turns_a_check_of_it_red(monkeypatch):
    """Beside the paper's arm, whose unharmed models pass; one test, as all share its answers."""
    brief(monkeypatch, BRIEF_S)
    perform_here(monkeypatch)
    # A cross-check compares no limit of a form: tests/engines/test_rigid_levels.py guards it.
    models = [name for name in MODELS if MODELS[name].role not in ("limit", "robot")]
    campaign = Campaign(PAPER, models)
    assert campaign.disagreeing == []
    for model in require_items(models):
        wrong = mutants(model, PAPER)
        assert len(wrong) > 100
        unseen = [str(mutant) for mutant in wrong if not _is_seen(campaign, mutant, monkeypatch)]
        assert unseen == []


def _is_seen(campaign: Campaign, mutant: Mutant, patch: pytest.MonkeyPatch) -> bool:
    """In a differing check that names the model; and the views can show what was found so far."""
    found = []
    for finding in campaign.findings(mutant, patch):
        found.append(finding)
        agreement = Agreement([finding])
        if agreement.disagreeing and mutant.model in (finding.left, finding.right):
            break
    agreement = Agreement(found)
    assert agreement.to_json()
    assert format_junit(agreement)
    named = [f for f in agreement.disagreeing if mutant.model in (f.left, f.right)]
    return bool(named) and agreement.exit_code == 1


@pytest.mark.parametrize("form", model_names("form"))
def test_a_form_of_the_paper_has_no_method_of_its_own(form):
    methods = {name for name, value in vars(Model).items() if callable(value)} - {"__init__"}
    shared = load_model_class("analytic:physical").__mro__
    own = [owner for owner in load_model_class(form).__mro__ if owner not in shared]
    assert own
    assert not methods & {name for owner in own for name in vars(owner)}
