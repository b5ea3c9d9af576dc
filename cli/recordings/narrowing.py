"""``dineros narrow``: proposals of a recording for callbacks, and the narrowed model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from dineros.cli.console import say, say_json, summarise, warn
from dineros.metamodel.errors import DinerosError, Location, counted

if TYPE_CHECKING:
    from dineros.cli.recordings.evidence import Evidence
    from dineros.metamodel import sym
    from dineros.observation.importing.given import Given
    from dineros.observation.measuring.proposing import TimeProposal
    from dineros.observation.narrowing import Narrowed, Proposal, Traced
    from dineros.observation.recordings import Calls, Untaken
    from dineros.observation.systems import ObservedSystem


@dataclass(frozen=True)
class Subject:
    """An imported model, as its observed system and the facts given for it."""

    model: Path
    system: ObservedSystem
    given: Given
    id: str


def subject_of(path: Path, model: sym.SystemModel) -> Subject:
    """Return the source of an imported model, as far as it is stored; warn if it was changed since."""
    from dataclasses import replace

    from dineros.metamodel.elements import is_unseen, node_net_of, nodes
    from dineros.observation.differences.described import described
    from dineros.observation.importing.building import to_model
    from dineros.observation.importing.given import Given
    from dineros.observation.importing.given_reading import given_beside, read_given

    found = described(model)
    system = replace(
        found.system,
        nodes=tuple(
            replace(node, lifecycle="active") if node.name in found.managed else node
            for node in found.system.nodes
        ),
    )
    beside = given_beside(path)
    given = read_given(beside) if beside.exists() else Given()
    again = to_model(system, given, str(model.id)).model
    seen = [
        {node.id for node in nodes(each) if not is_unseen(node_net_of(node))} for each in (again, model)
    ]  # invented nodes are not part of what was seen
    if seen[0] != seen[1]:
        warn(f"{path}: was changed after its import; only the changes in {beside.name} are kept")
    return Subject(path, system, given, str(model.id))


P = TypeVar("P", bound="Proposal | TimeProposal")


def chosen(found: Sequence[P], threshold: float | None, numbers: Sequence[int]) -> list[P]:
    """Return the proposals that are accepted.

    Raises
    ------
    DinerosError
        A number does not belong to a proposal.
    """
    for number in numbers:
        if not 0 < number <= len(found):
            known = f"there are {len(found)}" if found else "there is none"
            raise DinerosError(f"there is no proposal {number}", hint=known)
    return [
        each
        for number, each in enumerate(found, 1)
        if number in numbers or (threshold is not None and each.confidence >= threshold)
    ]


def refuse_given(output: Path) -> None:
    """Reject an output path if its file of given facts already exists.

    Raises
    ------
    DinerosError
        The file exists and may contain manual edits.
    """
    from dineros.observation.importing.given_reading import given_beside

    beside = given_beside(output)
    if beside.exists():
        raise DinerosError(
            "already exists and may contain manual edits",
            location=Location(beside),
            hint="name another file with -o",
        )


def write(made: Narrowed, output: Path, evidence: Evidence) -> None:
    """Write a narrowed model, and next to it the facts now given for its system."""
    from dineros.metamodel.files import save
    from dineros.metamodel.files.atomic import write_atomically
    from dineros.observation.importing.given_reading import given_beside
    from dineros.observation.narrowing.written import given_text

    shown = "".join(f"#   {proposal}\n" for proposal in (*made.accepted, *made.times))
    names = dict.fromkeys(path.name for path in (evidence.source, evidence.tracing) if path)
    seen = f"{' and '.join(names)} {'show' if len(names) > 1 else 'shows'}"
    head = f"# Facts that {seen} of {output.name}, and the facts given before.\n{shown}\n"
    save(made.imported.model, output)
    write_atomically(given_beside(output), (head + given_text(made.given)).encode())


def print_proposals(found: Sequence[Proposal | TimeProposal], bag: Path) -> None:
    """Print proposals with their numbers."""
    width = len(str(len(found)))
    for number, proposal in enumerate(found, 1):
        say(f"{number:>{width}}  {proposal}")
    if not found:
        summarise(f"{bag}: no proposals")


def print_calls(calls: Mapping[str, Calls], untaken: Sequence[Untaken]) -> None:
    """Print how services answered, according to events of them and their clients, and untaken responses."""
    from dineros.observation.systems import REQUEST_RECEIVED, REQUEST_SENT, RESPONSE_RECEIVED, RESPONSE_SENT

    ends = (("the server", REQUEST_RECEIVED, RESPONSE_SENT), ("clients", REQUEST_SENT, RESPONSE_RECEIVED))
    for service, told in calls.items():
        for who, asked, answered in ends:
            if told.events[asked]:
                count, least, most = told.answers.get(answered, (0, 0.0, 0.0))
                times = f", within {least * 1e3:.3g} to {most * 1e3:.3g} ms" if count else ""
                requests = counted(told.events[asked], "request")
                say(f"{service}: {count:,} of {requests} answered{times}; by {who}")
    for each in untaken:
        say(str(each), "bold red")


def print_narrowed(made: Narrowed, output: Path, evidence: Evidence) -> None:
    """Print the result of accepted proposals, and untaken responses."""
    bag = evidence.source
    for each in evidence.untaken:
        say(str(each), "bold red")
    for time in made.unheld:
        warn(f"omitted, because the model has no such callback: {time}")
    for proposal in made.dropped:
        warn(f"withdrawn, because no run of the narrowed model would match the recording: {proposal}")
    if made.verdict.status == "unknown":
        warn(f"whether {output} explains {bag} is unknown: {made.verdict.reason}")
    elif made.verdict.unexplained is not None:
        warn(f"{output} does not explain {bag}: {made.verdict.unexplained}")
    for silence in made.verdict.silences:
        warn(f"{output}: {silence}")
    explained = counted(made.verdict.messages, "message")
    accepted = counted(len(made.accepted) + len(made.times), "proposal")
    summarise(f"{output}: {accepted} accepted; explains {explained} of {bag}")


def print_traced(evidence: Evidence) -> None:
    """Print the number of messages in tracing files, and how many of them callbacks published."""
    counts = evidence.traced
    if counts is not None:
        callbacks = counted(len(counts.runs), "callback")
        messages = counted(sum(counts.messages.values()), "message")
        runs = counted(sum(counts.runs.values()), "run")
        say(f"{evidence.tracing}: {runs} of {callbacks}; {counts.outside:,} of {messages} outside of them")


def print_json(
    subject: Subject,
    evidence: Evidence,
    made: Narrowed | None,
    output: Path | None,
) -> None:
    """Print all of it as JSON."""
    report: dict[str, Any] = {
        "model": str(subject.model),
        "proposals": [each.to_dict() for each in evidence.proposals],
        "times": [each.to_dict() for each in evidence.times],
        "services": {
            service: {
                "events": dict(told.events),
                "answers": {
                    end: {"count": count, "least": least, "most": most}
                    for end, (count, least, most) in told.answers.items()
                },
            }
            for service, told in evidence.calls.items()
        },
        "untaken": [each._asdict() for each in evidence.untaken],
        "tracing": _tracing(evidence.traced),
        "narrowed": None,
    }
    if made is not None:
        report["narrowed"] = {
            "model": str(output),
            "accepted": [each.to_dict() for each in made.accepted],
            "dropped": [each.to_dict() for each in made.dropped],
            "times": [each.to_dict() for each in made.times],
            "status": made.verdict.status,
            "messages": made.verdict.messages,
        }
    say_json(report)


def _tracing(counts: Traced | None) -> dict[str, Any] | None:
    if counts is None:
        return None
    return {
        "nodes": sorted(counts.nodes),
        "runs": sum(counts.runs.values()),
        "messages": sum(counts.messages.values()),
        "outside": counts.outside,
        "unknown": asdict(counts.uncertain),
        "discarded": counts.discarded,
        "odd": counts.odd,
    }
