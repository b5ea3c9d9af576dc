"""Whether ports of a topic match, as a question of a check."""

from __future__ import annotations

from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.witnesses.findings import Fault
from dineros.metamodel import sym
from dineros.metamodel.matching import mismatch


class Matching(Question):
    """Whether every subscriber gets the messages of every publisher of its topic."""

    NOT_MATCHED = Fault(
        "ports-not-matched",
        "warning",
        "A subscriber requests a stricter quality of service than a publisher offers, and receives nothing "
        "from it.",
        "{subscriber} receives no message of {publisher} (topic {topic}): {reason}; to fix it, set {fix}",
    )
    faults = (NOT_MATCHED,)
    asks = "whether ports match"

    def ask(self, checked: Checked) -> None:
        """Compare the quality of service of each pair of ports."""
        channels = checked.model.channels if isinstance(checked.model, sym.SystemModel) else ()
        for channel in channels:
            if not isinstance(channel, sym.TopicChannel):
                continue
            for publisher in channel.publishers:
                for subscriber in channel.subscribers:
                    found = mismatch(publisher, subscriber)
                    if found is not None:
                        ends = publisher.place.id, subscriber.place.id
                        checked.report.findings.append(
                            self.NOT_MATCHED.found(
                                channel.id,
                                *ends,
                                publisher=ends[0],
                                subscriber=ends[1],
                                topic=channel.topic,
                                reason=found.reason,
                                fix=found.fix,
                            )
                        )
