"""Whether messages and requests are lost: in full queues, or because of the state of a managed node."""

from __future__ import annotations

from functools import partial
from typing import ClassVar

from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.checks.ways import can_fire, firing_witness, why_unseen
from dineros.analysis.model.losses import Kind, Loss, losses_of
from dineros.analysis.model.queues import Queue, queues
from dineros.analysis.witnesses.findings import Fault, Finding
from dineros.analysis.witnesses.witness import Witness, witness_of_firing
from dineros.metamodel import sym
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.calls import actions
from dineros.metamodel.elements import label, node_net_of


class Overflow(Question):
    """Whether a queue can overflow."""

    LOSES = Fault(
        "queue-overflow",
        "error",
        "A queue can be full when a message arrives, which is then lost.",
        "{queue} can overflow: {loss}",
    )
    SAMPLES = Fault(
        "sample-lost",
        "note",
        "A history of a best-effort publisher, or of feedback, can be full: the oldest message is lost.",
        "{queue} can overflow: {loss}, which the model allows",
    )
    DISPLACED = Fault(
        "message-displaced",
        "note",
        "A full history discards an older message of a reader that needs only the newest one.",
        "{queue} can overflow: the oldest message is lost, and {reader} needs only the newest one{assumed}",
    )
    faults = (LOSES, SAMPLES, DISPLACED)
    asks = "which queues can overflow"
    reads_firings = True

    def ask(self, checked: Checked) -> None:
        """Look for a marking in which a message would be lost."""
        for queue in queues(checked.subject):
            with checked.guarded(partial(self._leave_open, checked, queue)):
                self._ask_of(checked, queue)

    def _leave_open(self, checked: Checked, queue: Queue, reason: str) -> None:
        found = self._found(queue, None)
        may_be_fault = found.severity != "note"
        asks = f"whether {queue} can overflow"
        checked.leave_open(asks, reason, "", may_be_fault, found.elements, found.rule)

    @classmethod
    def ask_early(cls, checked: Checked) -> None:
        """Put queues into the report that are met overflowing, before a state space that may take long."""
        if not checked.is_shown:
            return
        known = checked.near
        for queue in queues(checked.subject):
            if not checked.has_time_for_runs:
                return
            drops = [checked.subject.transition_index[drop] for drop in queue.drops]
            if not known.traces.keys().isdisjoint(drops):
                with checked.showing():
                    way = witness_of_firing(checked.subject, known.way_to(drops), checked.rounds_tried)
                checked.report.findings.append(cls._found(queue, way))
                checked.told.add(queue.load)

    def _ask_of(self, checked: Checked, queue: Queue) -> None:
        if queue.load in checked.told:
            return
        overflows = can_fire(checked, queue.drops)
        if overflows is None:
            self._leave_open(checked, queue, checked.why_open)
        elif not overflows:
            checked.report.proved.append(f"{queue} never overflows")
        else:
            if checked.is_shown and not checked.has_time_for_runs:
                checked.report.findings.append(self._found(queue, None))
                return
            with checked.showing():
                witness = firing_witness(checked, queue.drops)
            if witness is None:
                checked.leave_open(f"how {queue} overflows", why_unseen(checked))
            checked.report.findings.append(self._found(queue, witness))

    @classmethod
    def _found(cls, queue: Queue, witness: Witness | None) -> Finding:
        reader = queue.reader_of_newest
        if reader is not None:
            assumed = " (assumed, see newestOnly)" if "newestOnly" in (reader.assumed or "").split() else ""
            return cls.DISPLACED.found(
                *queue.elements, witness=witness, queue=queue, reader=label(reader.place), assumed=assumed
            )
        fault = cls.SAMPLES if queue.may_lose else cls.LOSES
        return fault.found(*queue.elements, witness=witness, queue=queue, loss=queue.loss)


class Presence(Question):
    """Whether messages and requests are lost because a managed node is not there, or not active."""

    INACTIVE = Fault(
        "published-while-inactive",
        "warning",
        "A managed node can publish while it is inactive: the message is lost.",
        "{loss}",
    )
    MISSED = Fault(
        "subscriber-not-there",
        "error",
        "A message can be published while its subscriber is not configured: it is lost.",
        "{loss}",
    )
    LEFT = Fault(
        "lost-with-node",
        "warning",
        "A managed node can be cleaned up or shut down with a message that is on its way: it is lost.",
        "{loss}",
    )
    UNSERVED = Fault(
        "server-not-there",
        "error",
        "A request can be sent while its server is not configured: it is lost, and never answered.",
        "{loss}",
    )
    UNANSWERED = Fault(
        "request-lost-with-server",
        "error",
        "A server can be cleaned up or shut down with a request that it has: it is never answered.",
        "{loss}",
    )
    GIVEN_UP = Fault(
        "request-given-up",
        "note",
        "A request can be lost because its server is not there, or leaves; its client gives it up.",
        "{loss}",
    )
    EXPIRED = Fault(
        "message-expires",
        "note",
        "A message can be older than its lifespan before it is taken: it is not delivered.",
        "{loss}",
    )
    GOALS_STAY = Fault(
        "goals-outlive-server",
        "note",
        "The answers assume that clients wait for the managed server of an action, and goals outlive it.",
        "the answers assume that {client} of action {action} waits for its server, and its goals outlive "
        "{node}: with rclpy a goal that is sent while {node} is not configured, or that it has when it "
        "leaves, gets no result",
    )
    faults = (INACTIVE, MISSED, LEFT, UNSERVED, UNANSWERED, GIVEN_UP, EXPIRED, GOALS_STAY)
    asks = "whether messages and requests are lost because a node is not there"
    reads_firings = True

    _KINDS: ClassVar[dict[Kind, tuple[Fault, str]]] = {
        "inactive": (INACTIVE, "no managed node publishes while it is inactive"),
        "missed": (MISSED, "every subscriber exists when messages are published"),
        "left": (LEFT, "no message is lost with a node that is cleaned up or shut down"),
        "unserved": (UNSERVED, "every server exists when requests are sent"),
        "unanswered": (UNANSWERED, "no request is lost with a server that is cleaned up or shut down"),
        "given up": (GIVEN_UP, "no client has to give up because its server is not there"),
        "expired": (EXPIRED, "no message is older than its lifespan before it is taken"),
    }

    def ask(self, checked: Checked) -> None:
        """Look for a run that loses a message so, for each publisher and each pair of ports."""
        self._assume(checked)
        losses = losses_of(checked.subject.links())
        for kind, (fault, proved) in self._KINDS.items():
            some = [loss for loss in losses if loss.kind == kind]
            excluded = 0
            for loss in some:
                with checked.guarded(partial(self._leave_open, checked, fault, loss)):
                    excluded += self._is_excluded(checked, fault, loss)
            if some and excluded == len(some):
                checked.report.proved.append(proved)

    @staticmethod
    def _leave_open(checked: Checked, fault: Fault, loss: Loss, reason: str) -> None:
        asks = f"whether this can happen: {loss.text}"
        checked.leave_open(asks, reason, elements=loss.elements, rule=fault.rule)

    @classmethod
    def _assume(cls, checked: Checked) -> None:
        """Report what the rules of actions assume of managed servers and of clients written by hand."""
        if not isinstance(checked.model, sym.SystemModel) or checked.model.middleware != sym.Middleware.ros2:
            return
        for action in actions(checked.model):
            server = node_net_of(action.server.entry)
            if server is None or server.lifecycle is None:
                continue
            for client in action.clients:
                if runs_callbacks(node_net_of(client.goal)):
                    found = cls.GOALS_STAY.found(
                        action.id,
                        client.goal.id,
                        client=f"client {client.client}",
                        action=action.action,
                        node=f"node net {label(server)}",
                    )
                    checked.report.findings.append(found)

    @classmethod
    def _is_excluded(cls, checked: Checked, fault: Fault, loss: Loss) -> bool:
        """Return whether a loss is proved impossible; add other results about it to the report."""
        can_happen = can_fire(checked, loss.transitions)
        if can_happen is None:
            cls._leave_open(checked, fault, loss, checked.why_open)
        elif can_happen:
            witness = firing_witness(checked, loss.transitions)
            if witness is None:
                checked.leave_open(f"how this comes about: {loss.text}", why_unseen(checked))
            checked.report.findings.append(fault.found(*loss.elements, witness=witness, loss=loss.text))
        return can_happen is False
