"""The Petri Net Engine: executes a runtime model as one ROS node (paper, Sect. 5.2 and 9.3).

It is small enough for a robot: it imports neither the analysis nor the rules. Developers use a `Net`; a
`Node` connects a net to a transport and a recorder.
"""

from dineros.runtime.firing.handlers import Firing, Given, Handler, HandlerError
from dineros.runtime.firing.policies import Aside, Halt, Policy, Retry
from dineros.runtime.firing.selection import Candidates, Choice, Enabled
from dineros.runtime.nets.signals import Signal
from dineros.runtime.nets.tokens import Token
from dineros.runtime.nodes.inspection import Inspection
from dineros.runtime.nodes.net import Net
from dineros.runtime.nodes.node import Node
from dineros.runtime.nodes.observers import Change

__all__ = [
    "Aside",
    "Candidates",
    "Change",
    "Choice",
    "Enabled",
    "Firing",
    "Given",
    "Halt",
    "Handler",
    "HandlerError",
    "Inspection",
    "Net",
    "Node",
    "Policy",
    "Retry",
    "Signal",
    "Token",
]
