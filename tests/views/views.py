"""All views, and the verdict on those of a kind of record."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from jinja2.bccache import Bucket, BytecodeCache

from crosscheck.report import rendering
from tests.faults.planting import Seen
from tests.views import agreements, comparisons, costs, others, trials
from tests.views.walker import walk

VIEWS = agreements.VIEWS | costs.VIEWS | trials.VIEWS | comparisons.VIEWS | others.VIEWS


class KeptCode(BytecodeCache):
    """Compiled templates: of most a fault changes nothing."""

    def __init__(self) -> None:
        self._code: dict[tuple[str, str], Any] = {}

    def load_bytecode(self, bucket: Bucket) -> None:
        """Code of a template of this name and text."""
        bucket.code = self._code.get((bucket.key, bucket.checksum))

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Keep it."""
        self._code[bucket.key, bucket.checksum] = bucket.code


KEPT_CODE = KeptCode()


@contextmanager
def fresh_templates() -> Iterator[None]:
    """Templates that have the filters as they are, and leave none behind."""
    forget = getattr(rendering.load_templates, "cache_clear", lambda: None)
    forget()
    rendering.load_templates().bytecode_cache = KEPT_CODE
    yield
    forget()


def judge_views(seen: Seen) -> str:
    """Whether the views of a kind of record show its numbers; each in turn, until one does not."""
    with fresh_templates():
        own = (
            v for name, v in VIEWS.items() if name.partition(" of ")[2].startswith(seen.quantity)
        )
        return "differ" if any(any(walk(view, 1)) for view in own) else "agree"
