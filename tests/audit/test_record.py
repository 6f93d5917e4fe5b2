"""What is kept as JSON comes back as it was, or not at all."""

import json
from dataclasses import asdict

from pydantic import TypeAdapter

from crosscheck.audit.errata.errata_texts import build_record
from crosscheck.audit.errata.erratum import Effect, Erratum, ErratumPair, attach_effects

ERRATUM = Erratum(
    "eq1", "equation", "Eq. 1", "a", "b", size=float("inf"), unit="N", trial=ErratumPair(abs, abs)
)
TRIED = attach_effects(ERRATUM, {"pd": Effect(1e-3, 5.0, 0.1)})


def test_a_record_survives_being_kept():
    kept = json.loads(json.dumps(asdict(TRIED), allow_nan=False))
    assert TypeAdapter(type(TRIED)).validate_python(kept) == TRIED


def test_a_tried_erratum_has_no_trial_left_and_no_infinite_size():
    assert TRIED.trial is None
    assert TRIED.size is None
    record = build_record("paper-labelled", TRIED)
    assert record["id"] == "erratum/paper-labelled/eq1"
    assert (record["size"], record["effects"]["pd"]["mesh_force_N"]) == (None, 5.0)
