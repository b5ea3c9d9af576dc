"""Prints the findings of a check: as text, as JSON, for CI; writes witnesses to files."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Collection, Mapping, Sequence
from itertools import groupby
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.analysing import say_disorder, say_witness, write_witness
from dineros.cli.console import SEVERITIES, note, say, say_json, say_lines, summarise, warn
from dineros.cli.models import rules_of
from dineros.cli.options import invocation
from dineros.cli.presentation.answers import say_times, times_fields
from dineros.metamodel.errors import counted

_ALWAYS_SHOWN = ("suppression-expired", "suppression-unused")
"""Rules of notes that are printed without `-v`, because they require an action."""
_ENDS = ("topic-unheard", "topic-unfilled", "service-unserved", "names-near")
"""Rules for names with one end; for code, drivers and tools may be elsewhere."""

if TYPE_CHECKING:
    from dineros.analysis.model.times import LeftOutTimes
    from dineros.analysis.witnesses.code_lines import CodeLines
    from dineros.analysis.witnesses.findings import Fault, Finding, Report
    from dineros.metamodel import pn
    from dineros.metamodel.errors import Location


def print_report(
    report: Report,
    net: pn.Net,
    model: Path,
    format: str,
    witnesses: bool,
    faults: Mapping[str, Fault],
    command: str = "check",
) -> None:
    """Print findings: as ``text``, ``json``, ``sarif`` or ``junit``.

    `faults` are the kinds of findings by name; `command` is the command that found them.
    """
    from dineros.analysis.model.times import left_out_times
    from dineros.analysis.witnesses.code_lines import CodeLines

    left_out = left_out_times(net) if report.times is None else None
    lines = CodeLines(net)
    if format == "json":
        used = {} if report.times is None else {"times": {**report.times.to_dict(), "engine": report.by}}
        found = report.to_dict(str(model))
        for shown, finding in zip(found["findings"], report.findings, strict=True):
            if code := lines.of(finding):
                shown["code"] = [str(line) for line in code]
        say_json({**found, **rules_of(net), **times_fields(left_out, False), **used})
    elif format == "sarif":
        from dineros.analysis.witnesses.report_formats import to_sarif

        say_json(to_sarif(report, net, model, faults))
    elif format == "junit":
        from dineros.analysis.witnesses.report_formats import to_junit

        say_lines(to_junit(report, net, model, f"dineros {command}").decode())
    else:
        _print_text(report, model, witnesses, left_out, lines)


class Coming:
    """Prints answers on standard error as they come; the report follows on standard output.

    `accepted`: returns a report in which accepted findings are separate.
    """

    def __init__(self, report: Report, accepted: Callable[[Report], Report]) -> None:
        self._report, self._accepted = report, accepted
        self._told: set[str] = set()

    def __call__(self) -> None:
        """Print new answers: on a terminal, or with `-v`; a file gets only the report."""
        if not (sys.stderr.isatty() or invocation().verbosity > 0):
            return
        report = self._accepted(self._report)
        found = [
            f"{finding.severity}: {finding.message} [{finding.rule}]"
            for finding in report.findings
            if finding.severity != "note"
        ]
        for line in [*found, *(f"unknown: {each}" for each in report.unknown)]:
            if line not in self._told:
                self._told.add(line)
                warn(f"so far: {line}")


def show_failures(report: Report) -> None:
    """Print the stack traces of errors inside questions, with `--debug`."""
    if invocation().debug:
        for error in report.failures:
            traceback.print_exception(error)


def write_witnesses(
    report: Report, output: Path, model: Path, settings: Sequence[str], say_files: bool
) -> None:
    """Write the witness of each finding to a file of its own."""
    found = [finding for finding in report.findings if finding.witness]
    for number, finding in enumerate(found, 1):
        assert finding.witness is not None
        path = output if number == 1 else output.with_name(f"{output.stem}.{number}{output.suffix}")
        write_witness(finding.witness, path, model, settings, finding.message, finding.rule)
        if say_files:
            summarise(f"{model} -> {path}: {counted(len(finding.witness.steps), 'step')}")


def _print_text(
    report: Report, model: Path, witnesses: bool, times: LeftOutTimes | None, lines: CodeLines
) -> None:
    for finding in report.findings:
        if finding.severity == "note":
            tell = say if finding.rule in _ALWAYS_SHOWN else note
            tell(f"note: {finding.message}{_at(lines.of(finding), ' (at ', ')')} [{finding.rule}]")
            continue
        length = f" [{counted(len(finding.witness.steps), 'step')}]" if finding.witness else ""
        say(f"{finding.severity}: {finding.message}{length} [{finding.rule}]", SEVERITIES[finding.severity])
        if code := lines.of(finding):
            say(_at(code, "    at "))
        if witnesses and finding.witness:
            say_witness(finding.witness)
        elif finding.witness:
            say_disorder(finding.witness)
        _print_consequences(finding)
    displaced = sum(finding.rule == "message-displaced" for finding in report.findings)
    if displaced:
        where = counted(displaced, "queue")
        say(f"note: {where} can lose older messages; by newestOnly, the readers need only the newest one")
    from dineros.analysis.consequences import durations, lacks, lives

    can, undecided = _notes_that_depend(report, {"queue-overflow"}, durations.OPEN)
    if can:
        say(f"note: {counted(can, 'queue')} can overflow {durations.WHY}; -v lists them")
    if undecided:
        say(f"note: whether {counted(undecided, 'queue')} can overflow {durations.OPEN}; -v lists them")
    can, undecided = _notes_that_depend(report, lives.RULES, lives.OPEN)
    if can:
        say(f"note: messages can be lost in {counted(can, 'way')} {lives.WHY}; -v lists them")
    if undecided:
        say(f"note: whether messages are lost in {counted(undecided, 'way')} {lives.OPEN}; -v lists them")
    unused = sum(each.severity == "note" and each.message.endswith(lacks.WHY) for each in report.findings)
    if unused:
        say(f"note: no run uses {counted(unused, 'part')} of the model, {lacks.WHY}; -v lists them")
    ends = sum(finding.rule in _ENDS and finding.severity == "note" for finding in report.findings)
    if ends:
        say(f"note: {counted(ends, 'name')} without another end in this code; -v lists them")
    for suppressed in report.suppressed:
        say(f"suppressed: {suppressed.finding.message} [{suppressed.finding.rule}]: {suppressed.why}")
    for finding in report.known:
        note(f"known: {finding.message} [{finding.rule}]")
    of_notes = [unknown for unknown in report.unknown if unknown.rule and not unknown.may_be_fault]
    if of_notes:
        where = counted(len(of_notes), "queue")
        say(f"note: it is unknown whether {where} can overflow whose losses are only notes; -v lists them")
    for unknown in report.unknown:
        if unknown in of_notes:
            note(f"unknown: {unknown}")
        else:
            say(f"unknown: {unknown}", "magenta")
    for proved in report.proved:
        note(f"proved: {proved}")
    for assumed in report.assumed:
        note(f"proved under an assumption: {assumed}")
    for assumption in report.assumes:
        say(f"assumes: {assumption}")
    if report.times is not None:
        say(f"note: {report.times}; answered by: {report.by}")
    elif report.by:
        note(f"answered by: {report.by}")
    if times is not None:
        say_times(times, times.of_check)
    faults = sum(finding.severity != "note" for finding in report.findings)
    following = f" ({counted(len(report.consequences), 'consequence')})" if report.consequences else ""
    proofs = f"{len(report.proved)} proved"
    if report.assumed:
        proofs += f", {len(report.assumed)} proved under an assumption"
    counts = f"{faults} found{following}, {proofs}, {len(report.unknown) - len(of_notes)} unknown"
    summarise(f"{model}: {counts}{_accepted(report)}")


def _notes_that_depend(report: Report, rules: Collection[str], undecided: str) -> tuple[int, int]:
    """Return how many notes of some rules say that something can happen, and how many leave it undecided."""
    notes = [each for each in report.findings if each.rule in rules and each.severity == "note"]
    open_ones = sum(each.message.endswith(undecided) for each in notes)
    return len(notes) - open_ones, open_ones


def _print_consequences(finding: Finding) -> None:
    """Print the consequences of a cause; those of several causes together follow in lists of their own."""
    for others, some in groupby(finding.consequences, key=attrgetter("together")):
        for cause in others:
            say(f"    together with: {cause.message} [{cause.rule}]")
        indent = " " * (8 if others else 4)
        for each in some:
            say(f"{indent}consequence: {each.message} [{each.rule}]")


def _at(code: Sequence[Location], before: str, after: str = "") -> str:
    return f"{before}{', '.join(map(str, code[:4]))}{after}" if code else ""


def _accepted(report: Report) -> str:
    """Return the number of accepted findings, which do not count."""
    text = f", {len(report.suppressed)} suppressed" if report.suppressed else ""
    if report.has_baseline:
        text += f", {sum(finding.severity != 'note' for finding in report.known)} known"
        gone = counted(report.gone, "finding")
        text += f"; {gone} of the baseline no longer found" if report.gone and not report.unknown else ""
    return text
