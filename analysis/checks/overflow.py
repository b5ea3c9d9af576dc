"""Whether a queue can overflow."""

from __future__ import annotations

from dineros.analysis.checks.question import OUT_OF_MEMORY, Checked, Question
from dineros.analysis.checks.ways import firing_witness
from dineros.analysis.covering.firings import Firings
from dineros.analysis.model.queues import queues
from dineros.analysis.witnesses.findings import Fault, witness_of


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
            witness = firing_witness(checked, losing)
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
