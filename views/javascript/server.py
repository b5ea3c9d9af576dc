"""The process that runs JavaScript: ``python -P -m dineros.views.javascript.server``, started by the client.

Standard input is a socket; requests come and answers go there, each a line of JSON. It ends when the other
side does, at once, also in the middle of a request, also when the command was killed.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import socket
import sys
import threading
from functools import cache
from importlib.resources import files
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any

from dineros.views.javascript.modules import linked

if TYPE_CHECKING:
    from py_mini_racer import MiniRacer

DIES = "DINEROS_LAYOUTER"
"""With the value ``dies`` in the environment, every request ends the process by SIGSEGV: for tests."""

MODULES = "static/"
"""The folder of modules; their exports are global here."""

# What ELK expects of a browser: a global object, and timers, which need not wait here.
_BROWSER = """
var global = globalThis;
setTimeout = (work, delay, ...rest) => { Promise.resolve().then(() => work(...rest)); return 0; };
"""
# What a promise promises is there when the evaluation has ended: no timer really waits.
_SERVE = """
var served = {};
function serve(work, input) {
  served = {error: "no answer"};
  new Promise((done) => done(work(...JSON.parse(input)))).then(
    (value) => { served = {value}; },
    (error) => { served = {error: String(error && error.message || error)}; });
}
"""


def main() -> None:
    """Answer requests until the client disconnects; the argument is the memory limit in MiB."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # V8 reserves a terabyte of addresses
    connection = socket.socket(fileno=os.dup(sys.stdin.fileno()))
    requests: SimpleQueue[bytes] = SimpleQueue()
    threading.Thread(target=_listen, args=(connection, requests), daemon=True).start()
    while True:
        answer = json.dumps(_answer(json.loads(requests.get())))
        try:
            connection.sendall(answer.encode() + b"\n")
        except OSError:
            os._exit(0)


def _listen(connection: socket.socket, requests: SimpleQueue[bytes]) -> None:
    """Forward requests. The end of the stream ends the process, even while V8 is running."""
    try:
        for request in connection.makefile("rb"):
            requests.put(request)
    finally:
        os._exit(0)  # not by way of V8's own end


def _answer(request: dict[str, Any]) -> Any:
    if os.environ.get(DIES) == "dies":
        os.kill(os.getpid(), signal.SIGSEGV)
    try:
        engine = _engine(tuple(request["scripts"]))
        engine.eval(f"serve({request['function']}, {json.dumps(request['input'])})")
        return json.loads(str(engine.eval("JSON.stringify(served)")))
    except Exception as error:  # of this request only
        return {"error": (str(error).strip() or type(error).__name__).splitlines()[0]}


@cache
def _engine(scripts: tuple[str, ...]) -> MiniRacer:
    """Return V8 with scripts loaded; only the main thread, whose protection keys V8 gets, may call it."""
    from py_mini_racer import MiniRacer, init_mini_racer

    init_mini_racer(
        flags=("--single-threaded", f"--max-old-space-size={int(sys.argv[1])}"), ignore_duplicate_init=True
    )
    engine = MiniRacer()
    engine.eval(_BROWSER + _SERVE)
    for name in scripts:
        if name.startswith(MODULES):
            engine.eval(f"Object.assign(globalThis, {linked(name.removeprefix(MODULES))})")
        else:
            engine.eval(files("dineros.views").joinpath(name).read_text(encoding="utf-8"))
    return engine


if __name__ == "__main__":
    main()
