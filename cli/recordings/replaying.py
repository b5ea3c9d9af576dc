"""``dineros conform``: checks whether the model allows the traces of nodes."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.analysing import STATUSES, UNKNOWN, VIOLATED, write_witness
from dineros.cli.console import note, say, say_json, summarise
from dineros.cli.models import load_valid_system, say_rules, say_what_is_by_hand
from dineros.cli.presentation.findings import print_report
from dineros.cli.recordings.timing import ComparedTimes, compared_times, faults, report_of
from dineros.cli.searching import search
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.analysis.conformance import Verdict
    from dineros.metamodel import sym


def replay(
    model: Path,
    traces: Sequence[Path],
    orders: int,
    invariants: Sequence[str],
    allowance: float,
    output: Path | None,
    settings: Sequence[str],
    format: str,
) -> int:
    """Replay the traces of a run, print the result, and return the exit status."""
    from dineros.analysis.conformance import Verdict
    from dineros.analysis.conformance import conform as conform_traces
    from dineros.metamodel.records import read_trace, traces_of_runs

    parts = traces_of_runs(traces)
    settings = _with_rules_of_run(tuple(settings), parts.values())
    system = load_valid_system(model, settings)
    say_rules(system, model)
    say_what_is_by_hand([system], model)
    run = search()

    def so_far(ending: str) -> int:
        if format == "json":
            none = Verdict("unknown").to_dict(str(model))
            say_json({**none, "invariants": dict.fromkeys(invariants), "times": None, "reason": ending})
        else:
            summarise(f"{model}: unknown: {ending}")
        return UNKNOWN

    run.draft(so_far)
    run.stage(f"replaying the traces of {counted(len(parts), 'node')}")
    readers = {node: partial(read_trace, files) for node, files in parts.items()}
    verdict = conform_traces(
        system,
        readers,
        attempts=orders,
        firings=output is not None or bool(invariants),
    )
    run.stage("comparing times")
    times = compared_times(system, readers, allowance)
    run.stage("checking invariants")
    broken = _broken(system, invariants, verdict)
    if output is not None:
        run.stage(f"writing {output.name}")
        _write(verdict, system, output, model, settings, broken)
    with run.answer():
        if format == "json":
            held = {text: text not in broken for text in invariants}
            found = {**verdict.to_dict(str(model)), **({"status": "violated"} if times.breaches else {})}
            say_json({**found, "invariants": held, "times": times.to_dict()})
        elif format == "text":
            _print_invariants(invariants, broken)
            _print(verdict, times, model, len(parts))
        else:
            report = report_of(verdict, times.breaches)
            print_report(report, system, model, format, False, faults(), "conform")
    return VIOLATED if broken or times.breaches else STATUSES[verdict.status]


def _print_invariants(invariants: Sequence[str], broken: Mapping[str, int]) -> None:
    for text in invariants:
        if text in broken:
            say(f"{text}: does not hold after {counted(broken[text], 'firing')}", "bold red")
        else:
            say(f"{text}: holds throughout")


def _broken(system: sym.SystemModel, invariants: Sequence[str], verdict: Verdict) -> dict[str, int]:
    """Return the invariants that are violated in the run, each with the number of firings before."""
    if not invariants:
        return {}
    from dineros.analysis.conformance.invariants import Invariant
    from dineros.analysis.model.subject import subject_of

    subject = subject_of(system, "fully-enabled")
    found = {text: Invariant(text, subject).first_violation(verdict.sequence) for text in invariants}
    return {text: number for text, number in found.items() if number is not None}


def _with_rules_of_run(settings: tuple[str, ...], traces: Iterable[Sequence[Path]]) -> tuple[str, ...]:
    """Return the settings of the model for the run: the given ones, with the rules of the run.

    Raises
    ------
    DinerosError
        No setting is given, and not all nodes ran the same model.
    """
    if not settings:
        return _settings_of(traces)
    if any(map(_is_of_rules, settings)):
        return settings
    from dineros.metamodel.records import Header, read_records

    headers = [header for files in traces for header in islice(read_records(files[0]), 1)]
    rules = {
        setting
        for header in headers
        if isinstance(header, Header)
        for setting in header.settings
        if _is_of_rules(setting)
    }
    if len(rules) == 1:
        note(f"the traces say: --set {shlex.quote(min(rules))}")
    return (*settings, *rules) if len(rules) == 1 else settings


def _is_of_rules(setting: str) -> bool:
    return setting.partition("=")[0].strip() == "middleware"


def _settings_of(traces: Iterable[Sequence[Path]]) -> tuple[str, ...]:
    """Return the settings of the model for the run.

    Raises
    ------
    DinerosError
        Not all nodes ran the same model.
    """
    from dineros.metamodel.errors import DinerosError
    from dineros.metamodel.records import Header, read_records

    found: tuple[str, ...] | None = None
    for files in traces:
        header = next(read_records(files[0]))
        assert isinstance(header, Header)
        settings = tuple(header.settings)
        if found not in (None, settings):
            raise DinerosError(
                "was recorded with settings that differ from those of the other traces",
                location=header.location,
                hint="repeat with --set how the model was changed",
            )
        found = settings
    for setting in found or ():
        note(f"the traces say: --set {shlex.quote(setting)}")
    return found or ()


def _print(verdict: Verdict, times: ComparedTimes, model: Path, nodes: int) -> None:
    for deviation in verdict.violations:
        say(f"{deviation.location}: {deviation}", "bold red")
    for deviation in verdict.unknown:
        say(f"{deviation.location}: unknown: {deviation}", "magenta")
    for breach in times.breaches:
        say(f"{breach.location}: {breach}", "bold red")
    if times.is_simulated:
        note("the run was simulated, so its times are not compared with declared ones")
    steps = f"{counted(verdict.steps, 'step')} of {counted(nodes, 'node')}"
    status = "violated" if times.breaches else verdict.status
    summarise(f"{model}: {status}; {steps} replayed, {verdict.silent:,} more inside of channels")
    if times.compared:
        allowed = f"with an allowance of {times.allowance:g} s"
        broken = f"{counted(len(times.breaches), 'declared time')} broken"
        summarise(f"{counted(times.compared, 'time')} compared {allowed}: {broken}")


def _write(
    verdict: Verdict,
    system: sym.SystemModel,
    output: Path,
    model: Path,
    settings: Sequence[str],
    broken: Mapping[str, int],
) -> None:
    """Write the merged run; it is a witness of the first invariant that does not hold, if there is one."""
    from dineros.analysis.model.subject import subject_of
    from dineros.analysis.witnesses.first_cause import blocked_cause
    from dineros.analysis.witnesses.witness import witness_of

    subject = subject_of(system, "fully-enabled")
    witness = witness_of(subject, [subject.transition_index[name] for name in verdict.sequence])
    if broken:
        asked = f"G ({min(broken, key=lambda text: broken[text])})"
        write_witness(witness, output, model, settings, asked, "violated")
        return
    refused = [str(getattr(deviation.record, "transition", None)) for deviation in verdict.violations[:1]]
    causes = [blocked_cause(witness, transition) for transition in refused]
    write_witness(witness, output, model, settings, "conformance of a run", verdict.status, *causes)
