"""The Petri Net Engine: a runtime model drives one ROS node (paper, Sect. 5.2 and 9.3).

Small enough for a robot: it imports neither the analysis nor the rules. `Net` is what developers use; a
`Node` joins a net to a transport and a recorder.
"""

from dineros.runtime.core import Change
from dineros.runtime.handlers import Firing, HandlerError
from dineros.runtime.inspection import Inspection
from dineros.runtime.net import Net
from dineros.runtime.node import Node
from dineros.runtime.policies import Aside, Halt, Policy, Retry
from dineros.runtime.selection import Candidates, Choice, Enabled
from dineros.runtime.signals import Signal
from dineros.runtime.tokens import Token

__all__ = [
    "Aside",
    "Candidates",
    "Change",
    "Choice",
    "Enabled",
    "Firing",
    "Halt",
    "HandlerError",
    "Inspection",
    "Net",
    "Node",
    "Policy",
    "Retry",
    "Signal",
    "Token",
]
