"""The command line ``dineros``: one thin module per subcommand in `commands`."""

from dineros.metamodel.moved import find_moved

find_moved(
    __name__,
    {"pictures": "outputs", "reporting": "presentation.check_reports", "tracing": "presentation.traces"},
)
