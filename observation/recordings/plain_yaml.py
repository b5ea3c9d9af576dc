"""Reads untrusted YAML: a few nested lists and mappings, as recorders write them.

YAML can name a part and use it again (``&name``, ``*name``, ``<<``), so that a kilobyte expands to gigabytes.
Recorders do not use this, so it is rejected before anything is built. Deep nesting, which exhausts the stack
of parsers, is also rejected.
"""

from __future__ import annotations

from typing import Any

DEEPEST = 20
"""Limit of the nesting of lists and mappings; rosbag2 writes 6."""


class UnplainError(ValueError):
    """A text is not plain YAML; the message has the reason."""


def loaded(text: str) -> Any:
    """Return the value of a text.

    The caller limits the length: parsing takes about 6 s for 1 MiB.

    Raises
    ------
    UnplainError
        It is not YAML, is nested deeper than `DEEPEST`, or uses a part again.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        _check(text)
        return YAML(typ="safe").load(text)
    except (YAMLError, ValueError) as error:
        if isinstance(error, UnplainError):
            raise
        raise UnplainError(f"is not YAML: {str(error).splitlines()[0]}") from error


def _check(text: str) -> None:
    from ruamel.yaml import YAML
    from ruamel.yaml.events import AliasEvent, CollectionEndEvent, CollectionStartEvent, ScalarEvent

    depth = 0
    for event in YAML(typ="safe").parse(text):
        if isinstance(event, CollectionStartEvent):
            depth += 1
            if depth > DEEPEST:
                raise UnplainError(f"is nested deeper than {DEEPEST} lists and mappings")
        elif isinstance(event, CollectionEndEvent):
            depth -= 1
        elif isinstance(event, AliasEvent) or (isinstance(event, ScalarEvent) and event.value == "<<"):
            raise UnplainError("uses anchors or merge keys (&, *, <<), which no recorder writes")
