"""Reads untrusted YAML: a few nested lists and mappings, as recorders write them.

YAML can name a part and use it again (``&name``, ``*name``, ``<<``), so that a kilobyte expands to gigabytes.
Recorders do not use this, so it is rejected before anything is built. Deep nesting, which exhausts the stack
of parsers, is also rejected.
"""

from __future__ import annotations

from functools import cache
from typing import Any

DEEPEST = 20
"""Limit of the nesting of lists and mappings; rosbag2 writes 6."""

MOST = 150_000
"""Limit of the values; rosbag2 writes about 60 for a topic with one publisher."""


class UnplainError(ValueError):
    """A text is not plain YAML; the message has the reason."""


def loaded(text: str) -> Any:
    """Return the value of a text.

    The caller limits the length: parsing takes about 6 s of the processor for 1 MiB or 100 000 values.

    Raises
    ------
    UnplainError
        It is not YAML, is nested deeper than `DEEPEST`, has more than `MOST` values, or uses a part again.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    yaml = YAML(typ="safe", pure=True)
    yaml.Composer = _plain_composer()
    try:
        return yaml.load(text)
    except (YAMLError, ValueError) as error:
        if isinstance(error, UnplainError):
            raise
        raise UnplainError(f"is not YAML: {str(error).splitlines()[0]}") from error


@cache
def _plain_composer() -> type[Any]:
    """Return a class of the library that composes nodes of events; it rejects what is not plain."""
    from ruamel.yaml.composer import Composer
    from ruamel.yaml.events import AliasEvent, ScalarEvent

    class PlainComposer(Composer):
        values = 0

        def compose_node(self, parent: Any, index: Any) -> Any:
            event = self.parser.peek_event()
            if isinstance(event, AliasEvent) or (isinstance(event, ScalarEvent) and event.value == "<<"):
                raise UnplainError("uses anchors or merge keys (&, *, <<), which no recorder writes")
            if self.depth > DEEPEST or (self.depth == DEEPEST and not isinstance(event, ScalarEvent)):
                raise UnplainError(f"is nested deeper than {DEEPEST} lists and mappings")
            self.values += 1
            if self.values > MOST:
                raise UnplainError(f"has more than {MOST:,} values")
            return super().compose_node(parent, index)

    return PlainComposer
