"""The data that templates get about a system model: packages, nodes, ports, transitions, and all names."""

from dineros.generators.application.application import (
    Application,
    NodePackage,
    Place,
    Port,
    Signal,
    Transition,
)
from dineros.generators.application.collecting import application_of

__all__ = ["Application", "NodePackage", "Place", "Port", "Signal", "Transition", "application_of"]
