"""Data beside the JSON schemas of the files that commands write."""

import json
from functools import cache

from jsonschema import Draft202012Validator

from crosscheck.provenance import ROOT


@cache
def load_schema(name: str) -> Draft202012Validator:
    """What checks data by a schema, which is itself checked first: that takes longer than data."""
    text = (ROOT / "crosscheck" / "schema" / f"{name}.schema.json").read_text(encoding="utf-8")
    schema = json.loads(text)
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def assert_follows(data: object, name: str) -> None:
    """Data follow a schema. Raises what is wrong with them."""
    load_schema(name).validate(data)
