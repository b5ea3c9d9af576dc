"""Analysis of nets and of the models behind them: engines, reductions, temporal logic, and what users ask.

Importing this package does not import Numba; the engines do when they are first used.
"""

from dineros.metamodel.moved import find_moved

find_moved(
    __name__,
    {
        "goals": "questions.goals",
        "model_names": "model.names",
        "statespace": "questions.state_space",
        "subject": "model.subject",
        "witness_records": "witnesses.records",
    },
)
