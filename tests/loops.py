"""Loops of tests that must look at something."""

from collections.abc import Iterable, Iterator
from typing import TypeVar

Item = TypeVar("Item")


def require_items(items: Iterable[Item]) -> Iterator[Item]:
    """Yield the items. Raises AssertionError after none, so that no test passes by being empty."""
    count = 0
    for item in items:
        count += 1
        yield item
    assert count, "the test looked at nothing"
