"""The figures of a sweep: state space, time, and memory over varied features (paper, Figs 15 to 17)."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any

from dineros.metamodel.errors import DinerosError

FORMATS = (".svg", ".png", ".pdf")
"""Formats of figures."""

VARIANTS = ("signals", "overflow", "reduced")
"""Columns of a sweep's table that distinguish variants; the columns before them are varied features."""

_PANELS = (
    ("states", "state space: places (markings); dotted: transitions", 1.0),
    ("seconds", "time (s)", 1.0),
    ("peak_memory_bytes", "peak memory (MiB)", 1.0 / 2**20),
)
# Colours for all kinds of colour vision (after Paul Tol); markers and lines tell series apart as well.
_COLOURS = ("#4477aa", "#cc6677", "#228833", "#b8860b", "#8855aa", "#2a9db0", "#996633", "#667788")
_MARKERS = "osD^vPX*"
_LINES = ("-", "--", "-.")  # dotted are the transitions of a state space

Row = Mapping[str, Any]


def sweep_figures(rows: Sequence[Row], suffix: str = ".svg", *, title: str = "") -> bytes:
    """Draw the table of a sweep.

    The first varied feature is the axis; each combination of the others and of the variants is a series.
    Points without a result are crosses at the bottom.

    Parameters
    ----------
    rows : sequence of mapping
        Rows of the table, as `dineros.analysis.sweeps` makes them.
    suffix : str
        One of `FORMATS`.
    title : str
        What stands above.

    Raises
    ------
    DinerosError
        Matplotlib is not installed.
    """
    try:
        from matplotlib import rc_context
        from matplotlib.figure import Figure
    except ImportError:
        raise DinerosError(
            "figures need matplotlib", hint="pip install 'dineros[view]', or write .csv"
        ) from None
    axes, names = _axes_of(rows)
    series = _series_of(rows, axes)
    # Texts stay texts, and two runs make the same file.
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "dineros", "font.size": 9, "axes.grid": True}):
        figure = Figure(figsize=(12.5, 4.2), layout="constrained")
        panels = figure.subplots(1, len(_PANELS))
        for panel, (column, label, factor) in zip(panels, _PANELS, strict=True):
            _draw(panel, series, axes[0] if axes else None, column, factor)
            panel.set_title(label, fontsize=10)
            panel.grid(True, which="major", alpha=0.3)
            panel.grid(True, which="minor", alpha=0.1)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(
            handles, labels, loc="outside lower center", ncols=min(4, max(1, len(labels))), frameon=False
        )
        # Of a panel, not of the figure: what belongs to the figure stands where its legend does.
        panels[len(panels) // 2].set_xlabel(names or "model", fontsize=9)
        if title:
            figure.suptitle(title, fontsize=11)
        content = io.BytesIO()
        stamp = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(suffix, {})
        figure.savefig(content, format=suffix.removeprefix("."), dpi=160, metadata=stamp)
    return content.getvalue()


def _axes_of(rows: Sequence[Row]) -> tuple[list[str], str]:
    """Return the varied features, and the label of the first axis: all features that vary together."""
    columns = list(rows[0]) if rows else []
    axes = columns[: columns.index(VARIANTS[0])] if VARIANTS[0] in columns else []
    if not axes:
        return [], ""
    first = [row[axes[0]] for row in rows]
    same = [axis for axis in axes if [row[axis] for row in rows] == first]
    others = [axis for axis in axes if axis not in same]
    return [axes[0], *others], " = ".join(same)


def _series_of(rows: Sequence[Row], axes: Sequence[str]) -> dict[str, list[Row]]:
    """Return the rows of each series by its label; values equal in all rows are not in the labels."""
    telling = [
        column
        for column in (*axes[1:], *VARIANTS)
        if len({str(row[column]) for row in rows}) > 1 or column == "signals"
    ]
    series: dict[str, list[Row]] = {}
    for row in rows:
        words = [_word(column, row[column]) for column in telling]
        series.setdefault(", ".join(filter(None, words)) or "model", []).append(row)
    return series


def _word(column: str, value: Any) -> str:
    if column == "reduced":
        return "reduced" if value else ""
    if column in VARIANTS:
        return str(value) if value is not None else ""
    return f"{column} = {value}"


def _value(row: Row, column: str) -> Any:
    """Return the drawn values: for a reduced net its own markings, as in the paper."""
    return row["reduced_states"] if column == "states" and row.get("reduced_states") else row[column]


def _draw(panel: Any, series: Mapping[str, list[Row]], axis: str | None, column: str, factor: float) -> None:
    known = [row[axis] if axis else "" for rows in series.values() for row in rows]
    numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in known)
    places = list(dict.fromkeys(known))

    def x_of(row: Row) -> Any:
        value = row[axis] if axis else ""
        return value if numbers else places.index(value)

    for number, (label, rows) in enumerate(series.items()):
        values = [(row, _value(row, column)) for row in rows if row["complete"]]
        points = [(x_of(row), float(value) * factor) for row, value in values if value]
        style = {
            "color": _COLOURS[number % len(_COLOURS)],
            "marker": _MARKERS[number % len(_MARKERS)],
            "linestyle": _LINES[number // 2 % len(_LINES)],
        }
        panel.plot([x for x, _ in points], [y for _, y in points], label=label, markersize=5, **style)
        if column == "states":  # Fig. 15 shows the transitions of the state space as well
            arcs = [(x_of(row), float(row["arcs"])) for row in rows if row["complete"] and row.get("arcs")]
            dotted = {**style, "linestyle": ":", "markerfacecolor": "none"}
            panel.plot([x for x, _ in arcs], [y for _, y in arcs], markersize=4, linewidth=1, **dotted)
        for row in rows:
            if not row["complete"]:
                move = (number - (len(series) - 1) / 2) * 5
                panel.annotate(
                    "×", (x_of(row), 0), xycoords=panel.get_xaxis_transform(), xytext=(move, 4), ha="center",
                    textcoords="offset points", color=style["color"], fontsize=13, fontweight="bold",
                )  # fmt: skip
    panel.set_yscale("log")
    if not numbers:
        panel.set_xticks(range(len(places)), [str(place) for place in places])
    elif all(isinstance(value, int) for value in known):
        from matplotlib.ticker import MaxNLocator

        panel.xaxis.set_major_locator(MaxNLocator(integer=True))
    low, high = panel.get_ylim()
    if high / low < 8:  # a logarithmic axis over less than a decade would have no number on it
        middle = (low * high) ** 0.5
        panel.set_ylim(middle / 8**0.5, middle * 8**0.5)
        _plain_numbers(panel)


def _plain_numbers(panel: Any) -> None:
    from matplotlib.ticker import LogLocator, ScalarFormatter

    panel.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    panel.yaxis.set_major_formatter(ScalarFormatter())
    panel.yaxis.minorticks_off()
