"""Witnesses as traces: the records of `dineros.metamodel.records`, one per firing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from dineros.analysis.model.step_roles import StepRole, step_roles
from dineros.analysis.witnesses.first_cause import Cause, first_cause
from dineros.analysis.witnesses.witness import Witness
from dineros.metamodel.clauses import start_value
from dineros.metamodel.elements import node_nets
from dineros.metamodel.records import Fire, Header, Record


def witness_records(
    witness: Witness,
    *,
    source: str,
    settings: Sequence[str] = (),
    asked: str | None = None,
    verdict: str | None = None,
    cause: Cause | None = None,
) -> Iterator[Record]:
    """Yield the records of a witness: a header, then its steps.

    Parameters
    ----------
    witness : Witness
        The firing sequence, with the net it is one of.
    source : str
        File of the model.
    settings : sequence of str
        How the model was changed.
    asked, verdict : str, optional
        What was asked, and the answer that the witness proves.
    cause : Cause, optional
        Where the outcome may have begun, if what was asked does not say it.
    """
    subject = witness.subject
    assert subject is not None, "witness_of() made it"
    cause = cause or first_cause(witness, asked, verdict)
    net = None if subject.flattened is None else subject.flattened.net
    marking = zip(subject.net.places, subject.net.initial.tolist(), strict=True)
    yield Header(
        sequence=0,
        kind="witness",
        model=str(subject.model.id),
        source=source,
        settings=list(settings),
        property=asked,
        verdict=verdict,
        cause=None if cause is None else cause.first,
        causes=[] if cause is None else list(cause.steps),
        decided={} if cause is None else {text: list(span) for text, span in cause.decided.items()},
        # The header is record 0, so step i is record i + 1.
        loop=None if witness.loop is None else witness.loop + 1,
        signals=None if net is None else _variant(str(net.signals)),
        overflow=None if net is None else _variant(str(net.overflow)),
        marking={place: tokens for place, tokens in marking if tokens},
        signals_initial={
            signal.id: start_value(signal) for node in node_nets(subject.model) for signal in node.signals
        },
    )
    roles = step_roles(subject.links())
    for sequence, step in enumerate(witness.steps, 1):
        role = roles.get(step.transition, StepRole(Fire))
        yield role.kind(
            sequence=sequence,
            transition=step.transition,
            change=step.change,
            text=step.text if step.time is None else f"{step.text}, {step.time}",
            time=None if step.time is None else step.time.at,
            earliest=None if step.time is None else step.time.earliest,
            latest=None if step.time is None else step.time.latest,
            **role.fields(),  # type: ignore[arg-type]  # what its kind has
        )


def _variant(literal: str) -> str:
    """Return the name of a variant as options have it: `ioEnabled` is ``io-enabled``."""
    return "".join(f"-{letter.lower()}" if letter.isupper() else letter for letter in literal)
