"""What is damaged: good inputs of every kind, made by DiNeROS itself."""

from __future__ import annotations

from pathlib import Path

from dineros.metamodel.elements import find
from dineros.metamodel.files import save
from dineros.metamodel.pn import Transition
from dineros.metamodel.sym import Fairness, Property, TopicChannel
from dineros.transformations.flattening.split import split
from tests.fuzz.judging import run_command
from tests.generators.models import kitchen
from tests.support.programs.bags import write_bag
from tests.support.systems.small import small_net, small_system
from tests.support.systems.talker import talker


def made(*arguments: object) -> None:
    """Run a command that must succeed."""
    outcome = run_command(*arguments)
    assert outcome.status in (0, 1), outcome.said


def models(folder: Path, suffix: str) -> list[bytes]:
    """Return small models of every kind in a format."""
    folder.mkdir(exist_ok=True)
    plain = small_net()
    if suffix == "net":
        find(plain, "start", Transition).interval = None
    if suffix in ("xml", "cts"):
        find(plain, "stop", Transition).overrides.clear()
    save(plain, folder / f"plain.{suffix}")
    if suffix in ("net", "xml", "cts"):
        made("flatten", _saved(folder, "talker"), "-o", folder / f"flat.{suffix}")
    else:
        save(small_system(), folder / f"small.sym.{suffix}")
        save(talker(), folder / f"talker.sym.{suffix}")
        save(kitchen(), folder / f"kitchen.sym.{suffix}")
    if suffix == "xmi":
        save(split(kitchen())[0], folder / "node.rtm.xmi")
    return [path.read_bytes() for path in sorted(folder.glob(f"*.{suffix}"))]


def model(folder: Path) -> Path:
    """Return the file of the model that formulas, settings and traces speak of."""
    return _saved(folder, "talker")


def asked(folder: Path) -> Path:
    """Return the file of a model with a property and an assumption, for settings."""
    asked = talker()
    asked.properties.append(Property(id="Polite", text="never Heard >= 3"))
    asked.assumptions.append(Fairness(id="Saying", of="Say"))
    path = folder / "asked.sym.xmi"
    save(asked, path)
    return path


def _saved(folder: Path, name: str) -> Path:
    path = folder / f"{name}.sym.xmi"
    if not path.exists():
        save(talker() if name == "talker" else kitchen(), path)
    return path


def workspace(folder: Path) -> tuple[Path, Path]:
    """Return a model and a workspace generated from it."""
    path = _saved(folder, "kitchen")
    made("generate", path, "-o", folder / "workspace")
    return path, folder / "workspace"


def traces(folder: Path) -> Path:
    """Return a folder with the traces of a run of `model`."""
    made(
        "run", _saved(folder, "kitchen"), "--simulate", "--seed", 1, "--timeout", 2, "--trace", folder / "run"
    )
    return folder / "run"


def recordings(folder: Path) -> dict[str, Path]:
    """Return recordings of what `model` says, by how they are stored."""
    topics = [channel.topic for channel in talker().channels if isinstance(channel, TopicChannel)]
    messages = [(f"/{topic.strip('/')}", 10**8 * number) for topic in topics for number in range(3)]
    return {kind: write_bag(folder / kind, messages, storage=kind) for kind in ("mcap", "sqlite3")}


def witness(folder: Path) -> Path:
    """Return a witness of `model`."""
    made("find", model(folder), "--marking", "Noted >= 2", "-o", folder / "witness.jsonl")
    return folder / "witness.jsonl"


LTL = [
    b"G Words <= 3",
    b"F Noted = 3",
    b"G (Words + Said <= 3)",
    b"G (enabled(Say) -> F Noted >= 1) & !(Heard > 2 U X Noted = 3)",
    b"(Words >= 1 W Noted = 3) | F G (deadlock) R true",
]
CTL = [
    b"EF deadlock",
    b"AG EF (Noted = 3)",
    b"A (Words >= 1 U Said >= 1) & !E X (deadlock | Heard > 2)",
    b"AF AX (enabled(Say) -> Words * 2 - 1 >= 0)",
]
GOALS = [b"Noted >= 2 and Heard = 0", b"not (Words + 2 * Said <= 3) or enabled(Listen)", b"Heard != 1"]
CLAUSES = [b"Button", b"not Button and (Button or !Button)", b"(Button & !Button) | Button"]
SETTINGS = [
    b"Words.tokens=2",
    b"Chatter.subscriber.Heard.limit=3",
    b"Chatter.publisher.Said.reliability=bestEffort",
    b"Button.initial=true",
    b"talker.threads=2",
    b"Chatter.topic=/other",
    b"greeting.name=x",
    b"greeting.middleware=ros2",
    b"Chatter.subscriber.Heard.newestOnly=true",
    b"Heard.capacity=3",
    b"talker.execution=callbacks",
    b"Polite.text=never Heard >= 4",
    b"Polite.language=ltl",
    b"Saying.strong=true",
]
VARY = [b"Words.tokens=0..3", b"Words.tokens=0..10..2", b"Words.tokens,Chatter.subscriber.Heard.limit=1,2,5"]
LIMITS = [b"tokens=5000", b"instances=1", b"points=10"]
OPTIONS = [
    b"memory 500M",
    b"memory 1.5G",
    b"stale-after Button=2:keep",
    b"stale-after Button=0.5:true",
    b"filter Noted Heard",
    b"timeout 3",
    b"seed 7",
    b"keep Noted",
    b"maintainer Ann <ann@example.org>",
    b"license MIT",
    b"explain Noted",
]
DEPENDENCIES = [
    b'exec_depend = ["geometry_msgs", "python3-numpy"]\ntest_depend = ["libstdc++-dev"]\n'
    b"install_requires = [\"scipy>=1.10; python_version < '4'\"]\n",
    b"# nothing\n[table]\nkey = 1979-05-27T07:32:00Z\nother = {a = [1, 2.5e3], b = '''x'''}\n",
]
MESSAGES = [
    b'{"id": "waiter/Served/1", "lost": 0, "data": {"dish": "soup", "table": 3, "isHot": true,'
    b' "prices": [1.5, 2], "notes": {"a": "b"}, "guest": "Ann"}}',
    b'{"id": "waiter@5f0c/Served/12", "lost": 3, "data": {}}',
    b'{"id": "", "lost": 0, "data": {"dish": ""}}',
]
ANNOUNCEMENTS = [
    b'{"id": "ada@5f0c/Arrived/12", "content": "AAEAAAEAAAA=", "alone": false}',
    b'{"id": "", "content": "", "alone": true}',
]
PAYLOADS = [b"true", b"OFF", b'{"value": true}', b'{"value": "on"}', b'{"Red": true, "Button": "off"}']
REQUESTS = [
    b"PUT /signals/Button HTTP/1.1\nHost: localhost\nContent-Type: application/json\n\ntrue",
    b"PUT /signals HTTP/1.1\nHost: 127.0.0.1:8080\nOrigin: http://127.0.0.1:8080\nAuthorization: Bearer t\n\n"
    b'{"Button": true}',
    b"GET /signals/Button?x=1 HTTP/1.1\nHost: [::1]:8080\nSec-Fetch-Site: none\n\n",
    b"GET /signals HTTP/1.1\nHost: localhost\n\n",
]
QUERIES = [
    b"token=TOKEN&number=12&epoch=1a2b3c4d",
    b"token=TOKEN&number=&epoch=",
    b"epoch=a&token=TOKEN",
    b"number=999999999999999&token=TOKEN",
]
