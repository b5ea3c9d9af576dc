"""Whether a queue can overflow."""

from __future__ import annotations

from dineros.analysis.checks.question import OUT_OF_MEMORY, Checked, Question
from dineros.analysis.covering.firings import Firings
from dineros.analysis.model.queues import queues
from dineros.analysis.symbolic.saturation import DiagramMemoryError
from dineros.analysis.witnesses.findings import Fault, Witness, witness_of

NEAR = 64 << 20
"""Bytes for the search for a shortest way to a fault; one that is further off is found by the state space."""


class Overflow(Question):
    """Whether a queue can overflow."""

    LOSES = Fault(
        "queue-overflow",
        "error",
        "A queue can be full when a message arrives, which is then lost.",
        "{queue} can overflow: {loss}",
    )
    faults = (LOSES,)
    asks = "which queues can overflow"

    def ask(self, checked: Checked) -> None:
        """Look for a marking in which a message would be lost."""
        if checked.firings is not None:
            self._ask_on_the_way(checked, checked.firings)
            return
        for queue in queues(checked.subject):
            losing = next((drop for drop in queue.drops if checked.space.enabled(drop)), None)
            if losing is None:
                checked.report.proved.append(f"{queue} never overflows")
                continue
            witness = self._witness(checked, losing)
            if witness is None:
                checked.leave_open(f"how {queue} overflows", OUT_OF_MEMORY)
            checked.report.findings.append(
                self.LOSES.found(*queue.elements, witness=witness, queue=queue, loss=queue.loss)
            )

    def _ask_on_the_way(self, checked: Checked, known: Firings) -> None:
        subject = checked.subject
        for queue in queues(subject):
            drops = [subject.transition_index[drop] for drop in queue.drops]
            losing = [known.traces[drop] for drop in drops if drop in known.traces]
            if losing:
                witness = witness_of(subject, min(losing, key=len))
                checked.report.findings.append(
                    self.LOSES.found(*queue.elements, witness=witness, queue=queue, loss=queue.loss)
                )
            elif known.dead.issuperset(drops):
                checked.report.proved.append(f"{queue} never overflows")
            else:
                checked.leave_open(f"whether {queue} can overflow", known.why_open)

    @staticmethod
    def _witness(checked: Checked, transition: str) -> Witness | None:
        """Return a sequence that ends with a transition: a shortest one where few markings are nearer."""
        # Most models need no search.
        from dineros.analysis.questions.reachability import find_firing, way_to_firing

        subject = checked.subject
        number = subject.transition_index[transition]
        trace = find_firing(subject.net, number, checked.budget.share(most_bytes=NEAR)).trace
        if trace is None:
            try:
                trace = way_to_firing(checked.space, subject.names, number)
            except DiagramMemoryError:
                return None
        return witness_of(subject, trace)
