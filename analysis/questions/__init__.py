"""The questions that users ask, each answered with the engines."""

from dineros.metamodel.moved import find_moved

find_moved(
    __name__,
    {
        "capacities": "dineros.analysis.suggestions.capacities",
        **{
            name: f"dineros.analysis.checks.{name}"
            for name in ("check", "deadlocks", "matching", "question", "remedies", "repetition", "unused")
        },
        "report_formats": "dineros.analysis.checks.report_formats",
    },
)
