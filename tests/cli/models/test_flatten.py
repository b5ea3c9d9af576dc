"""``dineros flatten``."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from dineros.metamodel import pn, pnm, sym, trace
from dineros.metamodel.elements import arcs, find, places, transitions
from dineros.metamodel.files import load, load_any
from dineros.metamodel.files.schema import identity
from dineros.transformations.flattening.flatten import flatten
from tests.cli.conftest import Run

ROOT = Path(__file__).resolve().parents[3]
WATCHDOG = ROOT / "examples/watchdog_rules.py"


@pytest.fixture
def sorting(tmp_path: Path) -> Path:
    """Return the file of the case study, which has services and signals."""
    return Path(shutil.copy(ROOT / "case_study/sorting.sym.xmi", tmp_path))


def links_of(path: Path) -> list[trace.TraceLink]:
    model = load_any(path)
    assert isinstance(model, trace.TraceModel)
    return list(model.links)


@pytest.mark.parametrize("suffix", [".pnm", ".xmi", ".pnml", ".net"])
def test_the_net_and_its_trace_are_written(run: Run, model: Path, tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"flat{suffix}"
    result = run("flatten", model, "-o", out)
    source = load(model)
    assert isinstance(source, sym.SystemModel)
    expected = flatten(source)
    numbers = [len(list(what(expected.net))) for what in (places, transitions, arcs)]
    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout == (
        f"{model} -> {out}: {numbers[0]} places, {numbers[1]} transitions, {numbers[2]} arcs; "
        f"{len(expected.net.certificate)} place invariants hold\n"
    )
    written = load(out)
    ids = [node.id for node in (*places(expected.net), *transitions(expected.net))]
    assert [node.id for node in (*places(written), *transitions(written))] == ids

    links = links_of(tmp_path / "flat.trace.xmi")
    arcs_of_the_format = 0 if suffix == ".net" else numbers[2]
    assert len(links) == numbers[0] + numbers[1] + arcs_of_the_format
    by_target = {identity(link.target): link for link in links}
    load_place = by_target["Chatter.publisher.Said.Load"]
    assert (load_place.rule, load_place.role) == ("T2", "queue.load")
    assert isinstance(load_place.target, pn.Place)
    assert [type(cause).__name__ for cause in load_place.sources] == [
        "TopicChannel",
        "PublisherPort",
        "Place",
    ]


def test_the_pnm_tells_its_variants(run: Run, model: Path, tmp_path: Path) -> None:
    out = tmp_path / "flat.pnm"
    arguments = ("--signals", "io-enabled", "--overflow", "inhibitor", "--json")
    report = json.loads(run("flatten", model, "-o", out, *arguments).stdout)
    net = load(out)
    assert isinstance(net, pnm.PetriNetModel)
    assert (str(net.signals), str(net.overflow)) == ("ioEnabled", "inhibitor")
    assert report == {
        "model": str(model),
        "signals": "io-enabled",
        "overflow": "inhibitor",
        "places": len(places(net)),
        "transitions": len(transitions(net)),
        "arcs": len(list(arcs(net))),
        "invariants": len(net.certificate),
        "output": str(out),
        "trace": str(tmp_path / "flat.trace.xmi"),
    }


@pytest.mark.long
def test_again_gives_the_same_bytes(run: Run, sorting: Path, tmp_path: Path) -> None:
    out, beside = tmp_path / "flat.pnm", tmp_path / "flat.trace.xmi"
    assert run("flatten", sorting, "-o", out).exit_code == 0
    before = out.read_bytes(), beside.read_bytes()
    assert run("flatten", sorting, "-o", out).exit_code == 0
    assert (out.read_bytes(), beside.read_bytes()) == before


@pytest.mark.long
def test_settings_change_the_net_and_the_trace_stays_readable(
    run: Run, sorting: Path, tmp_path: Path
) -> None:
    out = tmp_path / "flat.pnm"
    arguments = ("--set", "TSense.clause=Sensor & !Sensor", "--set", "RedObjects.tokens=5")
    assert run("flatten", sorting, "-o", out, *arguments).exit_code == 0
    assert find(load(out), "RedObjects", pn.Place).tokens == 5
    by_target = {identity(link.target): link for link in links_of(tmp_path / "flat.trace.xmi")}
    disjunction = by_target["SensorService[1].TSense.D2"]  # the file's clause has one disjunction only
    assert [getattr(cause, "id", None) for cause in disjunction.sources] == ["TSense"]


@pytest.mark.long
def test_explain_speaks_of_both_directions(run: Run, sorting: Path) -> None:
    made = run("flatten", sorting, "--explain", "Pick[2].PickRun")
    assert (made.exit_code, made.stdout) == (
        0,
        "Pick[2].PickRun: place made by S4 as place from place PickRun, server instance 2\n",
    )
    both = run("flatten", sorting, "--explain", "LeftCellObjects", "--signals", "none").stdout.splitlines()
    assert both[0] == "LeftCellObjects: place made by T1 as topic from topic channel LeftCellObjects"
    assert both[1].startswith("topic channel LeftCellObjects: ")
    assert len(both) == 2 + int(both[1].split()[3])
    assert any(line.split() == ["T1", "transport", "LeftCellObjects.transport"] for line in both)
    unused = run("flatten", sorting, "--explain", "Sensor", "--signals", "none").stdout
    assert unused == "input signal Sensor: 0 elements of the net made from it\n"


def test_explain_as_json(run: Run, sorting: Path) -> None:
    explained = json.loads(run("flatten", sorting, "--explain", "SelectRed", "--json").stdout)["explained"]
    assert explained["origin"]["rule"] == "kept"
    assert explained["source"] == "Transition"
    literals = [link for link in explained["results"] if link["rule"] == "I2"]
    assert literals[0]["sources"] == [
        "literal 1 of disjunction 1 of input clause of transition SelectRed",
        "disjunction 1 of input clause of transition SelectRed",
        "input signal Red",
    ]


def test_explain_and_write_at_once(run: Run, model: Path, tmp_path: Path) -> None:
    result = run("flatten", model, "-o", tmp_path / "flat.pnm", "--explain", "Say")
    assert result.stdout.startswith("Say: transition kept from the system model\n")
    assert result.stdout.endswith("place invariants hold\n")
    assert (tmp_path / "flat.pnm").exists()


@pytest.mark.long
def test_a_users_rules_run_last(run: Run, sorting: Path, tmp_path: Path) -> None:
    out = tmp_path / "guarded.pnm"
    plain = json.loads(run("flatten", sorting, "-o", tmp_path / "plain.pnm", "--json").stdout)
    report = json.loads(run("flatten", sorting, "-o", out, "--rules", WATCHDOG, "--json").stdout)
    clients = len([port for port in load(sorting).eAllContents() if isinstance(port, sym.ClientPort)])
    added = {what: report[what] - plain[what] for what in ("places", "transitions", "arcs", "invariants")}
    assert added == {"places": 3 * clients, "transitions": 2 * clients, "arcs": 8 * clients, "invariants": 0}
    explained = run("flatten", sorting, "--rules", WATCHDOG, "--explain", "Pick.client.L.timeout").stdout
    assert explained == (
        "Pick.client.L.timeout: transition made by Watchdog as t_timeout "
        "from service channel Pick, client port L\n"
    )


IMPORTS = """from dineros.metamodel import pn, sym
from dineros.transformations.language.creation import New
from dineros.transformations.rules.notation import arc, place, transition
from dineros.transformations.language.patterns import Index, Made, Node
from dineros.transformations.language.rule import Rule
from dineros.transformations.rules.services import S1
from dineros.transformations.rules.signals import I4, I5FullyEnabled


class Mine(Rule):
    client = Node(sym.ClientPort)
"""


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (  # breaks an invariant
            "    ready = Made(S1.ready, of=client)\n"
            "    steal = transition('{client.client}.steal')\n"
            "    arcs = [arc(ready, steal)]\n"
            "    lhs = [client, ready]\n    rhs = [*lhs, steal, *arcs]\n",
            "firing L.steal changes the place invariant",
        ),
        (  # looks up what no rule of this variant makes
            "    change = Made(I5FullyEnabled.change)\n    lhs = [client, change]\n    rhs = lhs\n",
            "{path}:12: dangling lookup: Mine needs I5FullyEnabled to run before it",
        ),
        (  # a value of the wrong kind
            "    odd = place('{client.client}.odd', tokens=client.client)\n"
            "    lhs = [client]\n    rhs = [*lhs, odd]\n",
            "{path}:12: Place.tokens takes EInt, not ",
        ),
        (  # puts an element around the outermost page, which shows only when it runs
            "    odd = New(pn.Place, into=client.response.page.page.page.objects, id='odd')\n"
            "    lhs = [client]\n    rhs = [*lhs, odd]\n",
            "{path}:12: Mine.odd cannot be created",
        ),
        (  # counts up to a number that the model leaves open
            "    number = Index(upto=client.channel.instances)\n    lhs = [client, number]\n    rhs = lhs\n",
            "Mine cannot be matched",
        ),
    ],
    ids=["certificate", "order", "value", "container", "match"],
)
def test_a_fault_in_a_rule_is_one_line(
    run: Run, sorting: Path, tmp_path: Path, body: str, message: str
) -> None:
    path = tmp_path / "my_rules.py"
    path.write_text(f"{IMPORTS}{body}\n\nRULES = [Mine]\n", encoding="utf-8")
    result = run("flatten", sorting, "-o", tmp_path / "flat.pnm", "--rules", path, "--set", "Pick.instances=")
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert message.format(path=path) in result.stderr
    assert not (tmp_path / "flat.pnm").exists()


def test_an_invalid_model_is_refused(run: Run, broken: Path, tmp_path: Path) -> None:
    result = run("flatten", broken, "-o", tmp_path / "flat.pnm")
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert "is not valid: " in result.stderr
    assert not (tmp_path / "flat.pnm").exists()


def test_a_doubtful_model_is_flattened(run: Run, doubtful: Path, tmp_path: Path) -> None:
    assert run("flatten", doubtful, "-o", tmp_path / "flat.pnm").exit_code == 0


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        ([], "missing option '-o' or '--explain'"),
        (["-o", "flat.txt"], "flat.txt: '.txt' is not a format of nets"),
        (["-o", "flat"], "flat: has no suffix"),
        (["-o", "missing/flat.pnm"], "there is no folder 'missing' (create the folder first)"),
        (["-o", "greeting.sym.xmi"], "greeting.sym.xmi: is the system model itself (name another file)"),
        (["-o", "flat.pnm", "--signals", "never"], "'never' is not one of 'none'"),
        (["--explain", "Sayd"], "has the id 'Sayd' (did you mean 'Say' or 'Said'"),
        (["-o", "flat.pnm", "--set", "Wrods.tokens=1"], "did you mean 'Words'"),
    ],
)
def test_wrong_use_is_one_line_and_writes_nothing(
    run: Run, model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], part: str
) -> None:
    monkeypatch.chdir(tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    result = run("flatten", model.name, *arguments)
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert part in result.stderr
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
