"""Trials of this folder look for the line that must change."""

import pytest


@pytest.fixture(autouse=True)
def search_everywhere(source_search: None) -> None:
    """Every test asks for it."""
