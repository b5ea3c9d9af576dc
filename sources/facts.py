"""The facts of the code of a package, with file and line; the JSON of ``--facts``.

Values that the reader cannot determine are *open*: the text begins with ``open``, or has ``{...}`` for
unknown parts. The guide describes the schema.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from dineros.sources.interfaces import Interfaces
from dineros.sources.places import Place
from dineros.sources.variables import Known, Variable, once

OPEN = "open"
"""Prefix of unknown values."""
_OPEN_WITH = (f"{OPEN}:", f"{OPEN} ")
"""Prefixes of unknown values; ``open_gripper`` is a name."""


def is_open(value: object) -> bool:
    """Return whether a value of a fact is unknown, completely or in part.

    Examples
    --------
    >>> is_open("open: two values"), is_open("{name}/scan"), is_open("open_gripper"), is_open(None)
    (True, True, False, False)
    """
    return isinstance(value, str) and (value == OPEN or value.startswith(_OPEN_WITH) or "{" in value)


WHILE_READING = {"is_kept": False}
"""Metadata of a field that has a meaning only while code is read."""

TRANSFORM = "a transform"
"""What a lookup in a buffer of tf2 waits for."""

NODE, SPACE = "__node", "__ns"
"""Arguments of a program with the name and the namespace of its nodes, next to values of parameters."""

AWAITED = "await, without time-out"
"""The way of waiting that blocks no thread: a coroutine is suspended, and its callback group is held."""
NEVER_SET = ", and no code sets it"
"""The end of the way of waiting for an event that never ends."""
SPINS_OTHERS = "other nodes"
"""The way of spinning that runs only nodes that the callback's own executor does not run."""
TAKES_AWAY, MAY_TAKE_AWAY = "takes the node away", "may take the node away"
"""The way of spinning that takes a node out of an executor that runs it, or runs later without it."""
BARRIER = "barrier"
"""The way of ending a wait at a barrier, at which the callback waits, too."""
ALONE = "none"
"""The executor of a callback group in C++ that does not go with its node, and that no executor gets."""
PERHAPS_ALONE = "none that is known"
"""The same, where other code may give it to an executor."""
UNSPUN = "none that spins"
"""The executor of a node or a callback group in C++ that only an executor gets that never spins."""
NO_SPIN = "open: no spin was seen"
"""Executor of a node that no code in the folder spins."""

FOREVER = 1e8
"""Seconds from which on a time-out, a deadline or a lease counts as none."""

HELD = "held already"
"""The way of taking a lock that the same callback already holds and that is not recursive."""


@dataclass(eq=False)
class Entity:
    """A publisher, subscription, timer, service, client, action server, action client or callback group."""

    kind: str
    """Key of the list in the facts: ``publishers``, ``subscriptions``, ..."""
    port: str
    """The variable that holds it: ``self.scan``; ``(no variable)``."""
    at: Place
    """Where it is made."""
    name: str = ""
    type: str = ""
    """`name`, `type`: as written; open if unknown."""
    details: dict[str, Any] = field(default_factory=dict)
    """The rest, by the keys of the schema."""
    callbacks: dict[str, CallbackFact] = field(default_factory=dict)
    """By their role: ``callback``, ``execute``, ``goal``, ``cancel``, ``accepted``."""
    is_enabled: bool = True
    """Whether it is made with the default values of parameters and environment."""
    group: Entity | None = None
    is_lent: bool = False
    """Whether code that is not in the folder gets it, and may use it."""
    order: int = 0
    """Position in the start of its program, see `Effect.order`."""

    @property
    def is_anonymous_group(self) -> bool:
        """Whether it is a callback group without a variable: the entity that uses it refers to it."""
        return self.kind == "groups" and self.port == "anonymous"

    def to_json(self) -> dict[str, Any]:
        """Return the entity in the schema of the facts."""
        found: dict[str, Any] = {"port": self.port, "at": str(self.at)}
        if self.kind == "groups":
            found = {"name": self.port, "at": str(self.at)}
        if self.name:
            found["name"] = self.name
        if self.type:
            found["type"] = self.type
        found |= self.details
        if not self.is_enabled:
            found["enabled"] = False
        return found


class Item:
    """An item of the control flow of a callback, see `dineros.sources.branches`."""


@dataclass(eq=False)
class Effect:
    """An effect of a callback."""

    do: str
    """``publish``, ``call``, ``sleep``, ``wait_for_service``, ..."""
    what: str
    """The port, the seconds, the lock."""
    at: Place
    """Where."""
    when: str
    """``always``, ``conditional`` or ``in a loop``."""
    how: str = ""
    """How it waits: ``async``, ``await``, ``blocks``, a time-out."""
    entity: Entity | None = None
    """The affected entity, if known."""
    then: CallbackFact | None = None
    """What the answer begins."""
    timeout: float | None = None
    """Seconds that a wait has at most; None: no bound, or no wait."""
    holding: tuple[str, ...] = ()
    """Locks that are held meanwhile."""
    path: tuple[object, ...] = field(default=(), repr=False, metadata=WHILE_READING)
    """The calls that lead to it, while the code is read."""
    sends: dict[str, Known] = field(default_factory=dict)
    """Fields of the published message that have this value each time."""
    given: dict[str, bool] = field(default_factory=dict)
    """Fields of the message that the callback received: it has the effect only if they are true or false."""
    is_repeated: bool = False
    """Whether it is a wait with a time-out that a loop repeats until it succeeds."""
    order: int = 0
    """Position in the start of its program, from 1; what the same program does or makes later has a higher
    number. 0: not in its main function or a constructor, or unknown.
    """
    meanwhile: list[CallbackFact] = field(default_factory=list)
    """What else a goal begins, any number of times: callbacks of feedback and, if `then` is that of the
    result, of its acceptance.
    """
    variables: tuple[Variable, ...] = ()
    """Of a loop that waits: the variables that it asks for, if it asks for nothing else. A model that has
    them has the wait, too.
    """

    pace: float | None = None
    """Of a loop that sleeps: the least seconds of a turn."""
    turn: tuple[tuple[Effect, bool], ...] = ()
    """Of a loop that sleeps: what it publishes at most once in a turn, and whether it certainly does."""

    def to_json(self) -> dict[str, Any]:
        """Return the effect in the schema of the facts."""
        found: dict[str, Any] = {"do": self.do, "what": self.what, "at": str(self.at), "when": self.when}
        if self.how:
            found["how"] = self.how
        if self.timeout is not None:
            found["timeout"] = self.timeout
        if self.then is not None:
            found["then"] = self.then.name
        if self.holding:
            found["holding"] = list(self.holding)
        if self.given:
            found["if"] = self.given
        if self.sends:
            found["sends"] = {name: value[-1] for name, value in self.sends.items()}
        return found


@dataclass(eq=False)
class CallbackFact:
    """A callback, or other code of a node: its constructor, the main function, a thread."""

    name: str
    """Of its function."""
    kind: str
    """``subscription``, ``timer``, ``service``, ``execute``, ``done callback``, ``constructor``, ..."""
    at: Place
    """Where the function begins."""
    effects: list[Effect] = field(default_factory=list)
    """In the order of the code."""
    is_async: bool = False
    """Whether it is an ``async def``."""
    is_open: bool = False
    """Whether it may do more than its effects say: the reader could not follow it."""
    is_apart: bool = False
    """Whether it runs on a thread of its own, which does not belong to the executor."""
    is_many: bool = False
    """Whether several threads may run it at once."""
    body: list[Item] | None = field(default=None, repr=False)
    """The effects in their branches; None if the order could not be followed."""
    answers: dict[str, bool] = field(default_factory=dict)
    """Of a service: fields of its response that have this value each time."""
    lacks: str = ""
    """``always`` or ``conditional``, if it returns something else than rclpy needs: no response, no result;
    `LATER`, if it may send the response after it has returned (rclcpp).
    """

    def to_json(self) -> dict[str, Any]:
        """Return the callback in the schema of the facts."""
        found: dict[str, Any] = {
            "name": self.name,
            "kind": self.kind,
            "at": str(self.at),
            "effects": once(effect.to_json() for effect in self.effects),
        }
        if self.is_async:
            found["async"] = True
        if self.is_open:
            found["open"] = True
        if self.is_apart:
            found["thread"] = "its own"
        if self.answers:
            found["answers"] = self.answers
        return found


LATER = "later"
"""A callback of a service lacks its response when it returns: other code sends it."""

STARTING = ("constructor", "main", "module")
"""Kinds of code that runs, in its order, when a program starts."""

KINDS = (
    *("publishers", "subscriptions", "timers", "services", "clients"),
    *("action_servers", "action_clients", "groups", "parameters"),
)
"""Lists of a node in the facts."""


@dataclass(eq=False)
class NodeFact:
    """A node that a program creates."""

    cls: str
    """Class or function that creates it."""
    at: Place
    """Where that begins."""
    name: str = OPEN
    """As written; open where not known."""
    namespace: str = ""
    """As written."""
    base: str = "Node"
    """Base class, as the code names it."""
    executor: str = ""
    """The executor of its callbacks, in words."""
    threads: int | str = "not spun"
    """Of its executor; ``processors``, ``not spun``, ``open``."""
    managed: bool = False
    """Whether it has a lifecycle."""
    program: str = ""
    """Script or entry point that makes it."""
    pool: int = 0
    """Nodes of one program with the same number share an executor; 0: not known."""
    entities: list[Entity] = field(default_factory=list)
    callbacks: list[CallbackFact] = field(default_factory=list)
    also_in: list[str] = field(default_factory=list)
    """Other programs that make it."""
    home: str = ""
    """File of the program."""
    remappings: dict[str, str] = field(default_factory=dict)
    """That a launch file gives."""
    started: str = ""
    """Line of the launch file that starts it."""
    plugin: str = ""
    """Of a component: its class, as launch files name it."""
    variables: list[Variable] = field(default_factory=list)
    """Attributes with few values, of which all assignments are known."""
    others: list[tuple[Place, str]] = field(default_factory=list)
    """Nodes that libraries make besides: where, and in words."""
    is_lent: bool = False
    """Whether code that is not in the folder gets it, and may use its ports."""
    lent_to: list[tuple[Place, str]] = field(default_factory=list)
    """Functions and classes of unknown libraries that get the node itself: where, and their names."""
    spun: int = 0
    """Position in the start of its program at which an executor begins to run its callbacks, see
    `Effect.order`. 0: unknown.
    """
    process: int = 0
    """Number of the process among those that a launch file starts, as it may start a program repeatedly. 0:
    the only process of the program.
    """
    apart: dict[str, int] = field(default_factory=dict)
    """Executors that run only callback groups of the node, with their numbers of threads. The detail
    ``executor`` of a group names one.
    """

    @property
    def is_single(self) -> bool:
        """Whether one thread runs all callbacks."""
        return self.threads == 1 and not self.apart

    def group_of(self, entity: Entity) -> Entity | None:
        """Return the callback group of an entity; None: the default group.

        If one of several executors of the node has one thread, all groups that it runs are one.
        """
        group = entity.group
        own = None if group is None else group.details.get("executor")
        if own in self.apart:
            same = [each for each in self.of("groups") if each.details.get("executor") == own]
            return same[0] if self.apart[own] == 1 else group
        return None if self.apart and self.threads == 1 else group

    def is_beside(self, other: NodeFact) -> bool:
        """Return whether the process of this node also runs another."""
        is_same = self.program == other.program != "" and self.process == other.process
        return self is other or is_same

    def of(self, kind: str) -> list[Entity]:
        """Return the entities of a kind."""
        return [entity for entity in self.entities if entity.kind == kind]

    def to_json(self) -> dict[str, Any]:
        """Return the node in the schema of the facts."""
        found: dict[str, Any] = {"class": self.cls, "at": str(self.at), "name": self.name}
        if self.namespace:
            found["namespace"] = self.namespace
        found |= {
            "base": self.base,
            "executor": self.executor,
            "threads": self.threads,
            "managed": self.managed,
            "program": self.program,
        }
        if self.also_in:
            found["also_in"] = self.also_in
        for kind in KINDS:
            found[kind] = [entity.to_json() for entity in self.of(kind) if not entity.is_anonymous_group]
        found["callbacks"] = [callback.to_json() for callback in self.callbacks]
        if self.variables:
            found["variables"] = [variable.to_json() for variable in self.variables]
        return found


@dataclass(eq=False)
class Facts:
    """All facts that were read."""

    name: str
    """Of the folder, or of its package."""
    nodes: list[NodeFact] = field(default_factory=list)
    """In the order of their files."""
    launch: list[dict[str, Any]] = field(default_factory=list)
    """Launch files, in the schema of the facts."""
    unread: list[str] = field(default_factory=list)
    """Files that could not be read and code that could not be followed, a line each."""
    files: int = 0
    """How many files were read."""
    interfaces: Interfaces = field(default_factory=Interfaces)
    """What the folder's own files of messages, services and actions define."""

    @property
    def _language(self) -> str:
        """Of the nodes: ``cpp``, ``python``, or both."""
        found = {"python" if each.at.file.endswith(".py") else "cpp" for each in self.nodes}
        return " and ".join(sorted(found)) or "python"

    def to_json(self) -> dict[str, Any]:
        """Return all facts in their schema."""
        return {
            "name": self.name,
            "language": self._language,
            "nodes": [node.to_json() for node in self.nodes],
            "launch": self.launch,
            "unread": self.unread,
        }
