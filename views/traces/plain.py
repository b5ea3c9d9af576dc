"""A trace as SVG where the page's scripts cannot run: the same lanes and steps, with plainer marks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from html import escape
from typing import Any

_LABELS, _MARGIN, _HEIGHT, _TITLE = 232, 14, 20, 22
_LEAST, _MOST = 640, 1500  # pixels for the steps
_THEMES = {
    "light": {"back": "#ffffff", "ink": "#17212b", "soft": "#5b6773", "line": "#d5dbe1", "on": "#f6d58d"},
    "dark": {"back": "#12181f", "ink": "#e6ebf0", "soft": "#9aa7b4", "line": "#33404d", "on": "#5d4413"},
}
_HEADINGS = {
    "property": "Property",
    "lifecycle": "Managed nodes",
    "signals": "Signals",
    "topics": "Topics",
    "services": "Services",
    "actions": "Actions",
    "transitions": "Transitions",
}
_WORDS = {
    "l": "changes its state (0 unconfigured, 1 inactive, 2 active, 3 finalized)",
    "p": "publish",
    "k": "take",
    "d": "message lost",
    "q": "request",
    "s": "serve",
    "r": "reply",
    "a": "answer",
    "o": "late",
    "g": "given up",
    "c": "asks to cancel",
    "x": "is to be canceled",
    "b": "feedback",
    "h": "hears feedback",
    "f": "fires",
    "e": "fails",
    "z": "leaves tokens",
    "u": "takes them again",
}
"""What the letters of marks mean, but those of values (`v`, `n`), which stand for themselves."""


def plain_figure(
    views: Sequence[dict[str, Any]],
    theme: str = "light",
    *,
    filter: str = "",
    divergence: dict[str, Any] | None = None,
    **_: Any,
) -> str:
    """Draw traces one below the other; by number of steps, unfolded, whatever else is asked for.

    Parameters
    ----------
    views : sequence of dict
        What `TraceCoder.snapshot` returns.
    theme : {"light", "dark"}
        Colours.
    filter : str
        Words that a lane must hold; ``a|b`` is one or the other, ``-word`` must not be there.
    divergence : dict, optional
        The steps, ``a`` and ``b``, where two traces part.
    """
    colours = _THEMES[theme]
    longest = max((len(view["steps"]) for view in views), default=0)
    wide = min(max(_LEAST, 15 * longest), _MOST)
    parts: list[str] = []
    top, letters = float(_MARGIN), set[str]()
    for number, view in enumerate(views):
        apart = divergence["ab"[number]] if divergence else None
        top = _trace(parts, view, top, wide / max(longest, 1), wide, colours, filter, apart)
        letters |= {mark[1] for step in view["steps"] for mark in step.get("m", ())}
    meanings = ", ".join(f"{letter} {word}" for letter, word in _WORDS.items() if letter in letters)
    parts.append(_text(_MARGIN, top + 12, meanings, colours["soft"]))
    width, height = _LABELS + wide + 2 * _MARGIN, top + 20 + _MARGIN
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:g}" '
        f'viewBox="0 0 {width:g} {height:g}" font-family="Liberation Sans, Arial, sans-serif" font-size="11">'
        f'<rect width="100%" height="100%" fill="{colours["back"]}"/>{"".join(parts)}</svg>\n'
    )


def _trace(
    parts: list[str],
    view: dict[str, Any],
    top: float,
    each: float,
    wide: float,
    colours: dict[str, str],
    words: str,
    apart: int | None,
) -> float:
    """Draw one trace; return where it ends."""
    left, count = _LABELS + _MARGIN, len(view["steps"])
    what = ": ".join(filter(None, (view["verdict"], view["property"]))) or view["kind"]
    parts.append(_text(_MARGIN, top + 12, f"{view['title']} — {what}", colours["ink"], bold=True))
    top += _TITLE
    step = max(1, round(60 / each))
    for number in range(0, count, step):
        parts.append(_text(left + number * each, top + 10, str(number + 1), colours["soft"]))
    top += _HEIGHT
    begins, heading = top, None
    for lane, marks in _lanes(view, words):
        if lane["group"] != heading:
            heading = lane["group"]
            parts.append(_text(_MARGIN, top + 15, _HEADINGS[heading], colours["ink"], bold=True))
            top += _HEIGHT
        about = [lane.get("note"), lane.get("capacity") and f"≤ {lane['capacity']}"]
        note = " ".join(filter(None, about)) and f" ({' '.join(filter(None, about))})"
        title = " · ".join(filter(None, (lane["label"] + note, lane.get("node"))))
        parts.append(f'<g class="lane {lane["kind"]}" data-id="{escape(lane["id"])}">')
        parts.append(f"<title>{escape(title)}</title>")
        parts.append(_text(_MARGIN + 6, top + 14, _short(lane["label"] + note), colours["ink"]))
        parts += _lane(lane, marks, lambda at: left + at * each, count, top, colours)
        parts.append(
            f'<path d="M{left} {top + _HEIGHT}h{wide:g}" stroke="{colours["line"]}" stroke-width="0.5"/></g>'
        )
        top += _HEIGHT
    for at, label in ((view["loop"], "for ever from here"), (apart, "first divergence")):
        if at is not None:
            x = left + at * each
            parts.append(f'<path d="M{x:.1f} {begins}V{top}" stroke="{colours["soft"]}"/>')
            parts.append(
                _text(x + (3 if at < count / 2 else -3 - 6 * len(label)), top + 10, label, colours["soft"])
            )
    return top + _HEIGHT


def _lanes(view: dict[str, Any], words: str) -> Iterator[tuple[dict[str, Any], list[tuple[int, list[Any]]]]]:
    """Yield the lanes that something happens on, group by group, with the step and the rest of each mark."""
    marks: list[list[tuple[int, list[Any]]]] = [[] for _ in view["lanes"]]
    for at, step in enumerate(view["steps"]):
        for lane, *mark in step.get("m", ()):
            marks[lane].append((at, mark))
    for group, heading in _HEADINGS.items():
        for number, lane in enumerate(view["lanes"]):
            if lane["group"] == group and marks[number] and _matches(lane, heading, words):
                yield lane, marks[number]


def _matches(lane: dict[str, Any], heading: str, words: str) -> bool:
    names = ("id", "label", "note", "node", "channel")
    said = " ".join([*(str(lane.get(name, "")) for name in names), heading]).lower()
    return all(
        word[1:] not in said
        if word.startswith("-") and len(word) > 1
        else any(part and part in said for part in word.split("|"))
        for word in words.lower().split()
    )


def _lane(
    lane: dict[str, Any],
    marks: list[tuple[int, list[Any]]],
    x: Callable[[int], float],
    count: int,
    top: float,
    colours: dict[str, str],
) -> Iterator[str]:
    if lane["kind"] == "signal":
        changes = [(0, lane.get("initial", 0)), *((at, mark[1]) for at, mark in marks)]
        for (at, value), (until, _) in zip(changes, [*changes[1:], (count, None)], strict=True):
            if value and until > at:
                wide = x(until) - x(at)
                yield (
                    f'<rect x="{x(at):.1f}" y="{top + 4}" width="{wide:.1f}" height="12" '
                    f'fill="{colours["on"]}"/>'
                )
        return
    for at, mark in marks:
        yield (
            f'<path d="M{x(at):.1f} {top + 3}v14" stroke="{colours["soft"]}">'
            f"<title>{at + 1}: {_WORDS.get(mark[0], '')}</title></path>"
        )
        text = str(mark[1]) if mark[0] in ("n", "l") else mark[0]
        yield _text(x(at) + 2, top + 14, text, colours["ink"])


def _short(text: str, most: int = 36) -> str:
    return text if len(text) <= most else f"{text[: most - 1]}…"


def _text(x: float, y: float, text: str, colour: str, *, bold: bool = False) -> str:
    weight = ' font-weight="600"' if bold else ""
    return f'<text x="{x:.1f}" y="{y:g}" fill="{colour}"{weight}>{escape(text)}</text>'
