"""Runs that show an answer to a temporal question."""

from dineros.metamodel.moved import find_moved

find_moved(
    __name__, {"answer": "dineros.analysis.answers.outcome", "budget": "dineros.analysis.answers.budget"}
)
