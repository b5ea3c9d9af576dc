"""``dineros certify``: checks the certificate of an answer."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from dineros.cli.analysing import HOLDS, VIOLATED, load_valid
from dineros.cli.console import say, say_json
from dineros.cli.models import errors_of
from dineros.cli.options import json_option, model_argument
from dineros.cli.searching import search
from dineros.cli.supervising import search_command


@search_command(
    "dineros verify sorting.sym.xmi --ltl 'G Shown <= 3' --certificate s.json "
    "&& dineros certify sorting.sym.xmi s.json",
)
@model_argument()
@click.argument("certificate", type=click.Path(path_type=Path), metavar="CERTIFICATE")
@json_option
def certify(model: Path, certificate: Path, as_json: bool) -> int:
    """Check a certificate of find, verify or check, without the engines that found the answer.

    The model is changed and flattened as recorded in the certificate; the output shows how. The exit status
    is 0 if the certificate proves its answer, 1 if it does not.
    """
    from dineros.analysis.evidence.certificate import (
        BASE,
        TIMED_FORMAT,
        difference,
        read_certificate,
        subject_as,
    )
    from dineros.analysis.evidence.checker import refutation
    from dineros.analysis.evidence.timed_checker import timed_refutation
    from dineros.analysis.timed.timed_subject import TimedSubject
    from dineros.cli.presentation.evidence import facts_text
    from dineros.metamodel import sym

    found = read_certificate(certificate)
    net = load_valid(model, found["settings"])
    search().stage("checking the certificate")
    subject = subject_as(net, found["signals"], found["overflow"], found["format"] == TIMED_FORMAT)
    with errors_of(certificate):
        reason = difference(found, subject)
        if not reason and isinstance(subject, TimedSubject):
            reason = timed_refutation(found, subject)
        elif not reason:
            reason = refutation(found, subject)
    asked, answer = found["question"], found["answer"]
    if as_json:
        report = {"certificate": str(certificate), "valid": not reason, "reason": reason}
        report |= {"time": True} if isinstance(subject, TimedSubject) else {}
        names = ("question", "answer", "settings", "signals", "overflow")
        say_json({"model": str(model), **report, **{name: found[name] for name in names}})
        return VIOLATED if reason else HOLDS
    if reason:
        say(f"refuted: {certificate}: {reason}", "bold red")
        return VIOLATED
    text = f"enabled({asked['text']})" if asked["kind"] == "enabled" else asked["text"]
    changed = "".join(f" --set {shlex.quote(setting)}" for setting in found["settings"])
    base = found["signals"] == BASE
    variant = " without signals" if base else f" --signals {found['signals']} --overflow {found['overflow']}"
    options = changed + (variant if isinstance(net, sym.SystemModel) else "")
    options += " --time" if isinstance(subject, TimedSubject) else ""
    said = f"is {answer}" if answer.endswith("reachable") else answer
    say(f"valid: {text} {said} in {model}{options}", "green")
    say(f"  {facts_text(found)}")
    return HOLDS
