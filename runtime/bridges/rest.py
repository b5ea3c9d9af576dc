"""Input signals over HTTP: a server that others ask and tell (push), and a client that asks others (pull)."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from dineros.metamodel.errors import DinerosError, UnknownElementError
from dineros.runtime.bridges.values import SignalValueError, read_truth
from dineros.runtime.net import Net

if TYPE_CHECKING:
    from starlette.applications import Starlette
    from starlette.requests import Request
    from starlette.responses import Response

LOG = logging.getLogger("dineros.runtime.bridges")
_MISSING = "install dineros[rest]"


def signals_app(net: Net) -> Starlette:
    """Return a web application that shows and sets the signals of a net.

    ======  ==================  ================================================================
    GET     ``/signals``        all of them: ``{"Red": true, ...}``
    GET     ``/signals/NAME``   one: ``{"value": true}``
    PUT     ``/signals/NAME``   sets it: ``{"value": true}`` or the bare value
    ======  ==================  ================================================================

    Raises
    ------
    DinerosError
        The package starlette is not installed.
    """
    try:
        from starlette.applications import Starlette
        from starlette.responses import JSONResponse
        from starlette.routing import Route
    except ImportError as error:
        raise DinerosError("the web server is not there", hint=_MISSING) from error

    def show_all(request: Request) -> Response:
        return JSONResponse(dict(net.inspect().signals))

    async def one(request: Request) -> Response:
        try:
            signal = net.signal(request.path_params["name"])
        except UnknownElementError as error:
            return JSONResponse({"error": str(error)}, status_code=404)
        if request.method == "PUT":
            try:
                value = read_truth(await request.body())
            except SignalValueError as error:
                return JSONResponse({"error": str(error)}, status_code=422)
            signal.set(value, "rest")
            return JSONResponse({"value": value})
        return JSONResponse({"value": signal.value})

    return Starlette(
        routes=[Route("/signals", show_all), Route("/signals/{name:path}", one, methods=["GET", "PUT"])]
    )


class RestServer:
    """Serves `signals_app` on a thread of its own, for as long as it is open.

    Parameters
    ----------
    net : Net
        The net.
    host : str
        Where to listen; 127.0.0.1 keeps other machines out.
    port : int
        0: any free one.

    Raises
    ------
    DinerosError
        The packages starlette and uvicorn are not installed.
    """

    def __init__(self, net: Net, *, host: str = "127.0.0.1", port: int = 8080) -> None:
        try:
            import uvicorn
        except ImportError as error:
            raise DinerosError("the web server is not there", hint=_MISSING) from error
        self._host = host
        config = uvicorn.Config(
            signals_app(net), host=host, port=port, log_level="warning", lifespan="off", access_log=False
        )
        self._server: Any = uvicorn.Server(config)
        self._port = port
        self._thread = threading.Thread(target=self._serve, name="dineros rest", daemon=True)

    def _serve(self) -> None:
        try:
            self._server.run()
        except SystemExit:  # uvicorn's way to say that the port is taken
            LOG.error("nothing can be served on %s:%s", self._host, self._port)

    @property
    def url(self) -> str:
        """Where it serves, such as ``http://127.0.0.1:8080``; only while it is open."""
        port = self._server.servers[0].sockets[0].getsockname()[1]
        return f"http://{self._host}:{port}"

    def open(self, timeout: float = 10.0) -> None:
        """Begin to serve.

        Raises
        ------
        DinerosError
            The port is taken, or the server does not start in `timeout` seconds.
        """
        self._thread.start()
        end = time.monotonic() + timeout
        while not self._server.started:
            if not self._thread.is_alive() or time.monotonic() > end:
                self._server.should_exit = True
                raise DinerosError(
                    f"nothing can be served on {self._host}:{self._port}",
                    hint="another program may use the port",
                )
            time.sleep(0.01)

    def close(self) -> None:
        """Serve no more."""
        self._server.should_exit = True
        self._thread.join(10)

    def __enter__(self) -> RestServer:
        self.open()
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


class RestPoll:
    """Asks web servers for the values of signals again and again, for as long as it is open.

    What does not answer, or not with a truth value, is logged once and changes nothing.

    Parameters
    ----------
    net : Net
        The net.
    urls : mapping of str to str
        Id or name of a signal -> where its value is to be had: as JSON ``{"value": true}`` or as plain text.
    period : float
        Seconds between questions.
    timeout : float
        Seconds that an answer may take.

    Raises
    ------
    UnknownElementError
        The net has no such signal.
    DinerosError
        The package httpx is not installed.
    """

    def __init__(
        self, net: Net, urls: Mapping[str, str], *, period: float = 1.0, timeout: float = 5.0
    ) -> None:
        try:
            import httpx
        except ImportError as error:
            raise DinerosError("the web client is not there", hint=_MISSING) from error
        self._sources = [(net.signal(name), url) for name, url in urls.items()]
        self._period = period
        self._client = httpx.Client(timeout=timeout, follow_redirects=True)
        self._ending = threading.Event()
        self._failing: set[str] = set()
        self._thread = threading.Thread(target=self._run, name="dineros rest poll", daemon=True)

    def open(self) -> None:
        """Begin to ask."""
        self._thread.start()

    def close(self) -> None:
        """Ask no more."""
        self._ending.set()
        self._thread.join(10)
        self._client.close()

    def __enter__(self) -> RestPoll:
        self.open()
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _run(self) -> None:
        while not self._ending.is_set():
            for signal, url in self._sources:
                value = self._ask(url)
                if value is not None and value != signal.value:
                    signal.set(value, f"rest {url}")
            self._ending.wait(self._period)

    def _ask(self, url: str) -> bool | None:
        import httpx

        try:
            answer = self._client.get(url)
            answer.raise_for_status()
            value = read_truth(answer.text)
        except (httpx.HTTPError, httpx.InvalidURL, SignalValueError) as error:
            if url not in self._failing:
                LOG.warning("%s gives no truth value: %s", url, error)
            self._failing.add(url)
            return None
        self._failing.discard(url)
        return value
