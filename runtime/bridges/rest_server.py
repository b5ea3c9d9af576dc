"""A web server that shows and sets the signals of a net.

Access to its port alone is not trusted. A page in a browser can send requests to any address of the machine
that shows it. With a host name that points to that address (DNS rebinding), the page may even read the
responses. So the server checks the host in a request, refuses requests from other origins, and accepts values
as JSON or as a bare value, but not in the encoding of HTML forms. With a token, it serves only clients that
send the token.
"""

from __future__ import annotations

import asyncio
import ipaddress
import secrets
import threading
import time
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from dineros.metamodel.errors import DinerosError, UnknownElementError
from dineros.runtime.bridges.security import LOG, Credentials, SecurityError, Tls, is_own_machine
from dineros.runtime.bridges.values import (
    NAME_LIMIT,
    SIZE_LIMIT,
    SignalValueError,
    read_setting,
    read_signals,
)
from dineros.runtime.connections import (
    BACKLOG,
    UnknownClients,
    counting_protocol,
    handshaking_protocol,
    log_in_lines,
)
from dineros.runtime.nets.sources import Source
from dineros.runtime.nodes.net import Net
from dineros.runtime.scheduling.threads import join

if TYPE_CHECKING:
    from starlette.applications import Starlette
    from starlette.requests import Request
    from starlette.responses import Response
    from uvicorn.protocols.http.h11_impl import H11Protocol

HEADER_TIMEOUT = 10.0
"""Time limit in seconds for the head of a request, and then for its body."""

_FORMS = ("text/plain", "multipart/form-data", "application/x-www-form-urlencoded")
"""Content types that a page may send to any site without a preflight (Fetch standard, "CORS-safelisted")."""

_MISSING = "install dineros[rest]"


class _RefusedError(Exception):
    """A refused request: its status and the reason."""

    def __init__(self, status: int, reason: str) -> None:
        super().__init__(reason)
        self.status = status


def signals_app(
    net: Net, *, hosts: Iterable[str] = (), token: str | None = None, source: Source | None = None
) -> Starlette:
    """Return a web application that shows and sets the signals of a net.

    ======  ==================  ================================================================
    GET     ``/signals``        all of them: ``{"Red": true, ...}``
    GET     ``/signals/NAME``   one: ``{"value": true}``
    PUT     ``/signals/NAME``   sets it: ``{"value": true}`` or the bare value
    PUT     ``/signals``        sets several at once: ``{"Red": true, "Blue": false}``
    ======  ==================  ================================================================

    Parameters
    ----------
    net : Net
        The net.
    hosts : iterable of str
        Host names of this server, besides IP addresses and ``localhost``.
    token : str, optional
        Token that each request must contain, as ``Authorization: Bearer TOKEN``.
    source : Source, optional
        Counts accepted and refused requests.

    Raises
    ------
    DinerosError
        The package starlette is not installed.
    """
    try:
        from starlette.applications import Starlette
        from starlette.requests import ClientDisconnect
        from starlette.responses import JSONResponse
        from starlette.routing import Route
    except ImportError as error:
        raise DinerosError("the package for the web server is not installed", hint=_MISSING) from error
    known = frozenset(name.lower() for name in hosts)

    async def serve(request: Request) -> Response:
        try:
            _check(request, known, token)
            return JSONResponse(await _answer(net, request, source))
        except _RefusedError as error:
            if source is not None and request.method == "PUT":
                source.refuse(f"rest PUT, answered {error.status}", error)
            headers = {"Connection": "close"} if error.status in (408, 413) else {}
            if error.status == 401:
                headers["WWW-Authenticate"] = "Bearer"
            return JSONResponse({"error": str(error)}, status_code=error.status, headers=headers)
        except ClientDisconnect:
            return JSONResponse({}, status_code=400)

    return Starlette(
        routes=[Route(path, serve, methods=["GET", "PUT"]) for path in ("/signals", "/signals/{name:path}")]
    )


async def _answer(net: Net, request: Request, source: Source | None) -> Mapping[str, object]:
    name = request.path_params.get("name")
    if name is not None and len(name) > NAME_LIMIT:
        raise _RefusedError(404, f"no signal has a name of {len(name)} characters")
    if not request.scope["path"].isprintable():  # the path's pattern accepts a line feed at the end
        raise _RefusedError(404, "no signal has a name with control characters")
    try:
        if request.method != "PUT":
            if name is None:
                return {signal: net.signal(signal).value for signal in net.structure.signals}
            return {"value": net.signal(name).value}
        known = () if name is None else net.signal(name).values  # whether there is one comes first
        body = await _body(request)
        values = (
            read_signals(body, lambda each: net.signal(each).values)
            if name is None
            else {name: read_setting(body, known)}
        )
        net.set_signals(values, "rest")
    except UnknownElementError as error:
        raise _RefusedError(404, str(error)) from None
    except SignalValueError as error:
        raise _RefusedError(422, str(error)) from None
    if source is not None:
        source.accept()
    return values if name is None else {"value": values[name]}


def _check(request: Request, hosts: frozenset[str], token: str | None) -> None:
    """Refuse unauthorised or malformed requests."""
    headers = request.headers
    address = headers.get("host", "")
    if not _is_known(address, hosts):
        raise _RefusedError(421, f"this server does not have the name {address[:60]!r}")
    origin = headers.get("origin")
    if origin is not None and origin != f"{request.scope['scheme']}://{address}":
        raise _RefusedError(403, "requests from pages of another origin are rejected")
    if headers.get("sec-fetch-site", "none") not in ("none", "same-origin"):
        raise _RefusedError(403, "requests from pages of another site are rejected")
    if token is not None:
        given = headers.get("authorization", "").encode("utf-8", "replace")
        if not secrets.compare_digest(given, f"Bearer {token}".encode()):
            raise _RefusedError(401, "the token is missing or wrong")
    kind = headers.get("content-type", "").partition(";")[0].strip().lower()
    if request.method == "PUT" and kind in _FORMS:
        raise _RefusedError(415, f"{kind} is not supported: send Content-Type: application/json")


def _is_known(address: str, hosts: frozenset[str]) -> bool:
    """Return whether a Host header names this server; IP addresses are safe from DNS rebinding."""
    name = address[: address.index("]") + 1] if "]" in address else address.partition(":")[0]
    try:
        ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return name.lower() == "localhost" or name.lower() in hosts
    return True


async def _body(request: Request) -> bytes:
    content = bytearray()
    try:
        async with asyncio.timeout(HEADER_TIMEOUT):
            async for chunk in request.stream():
                content += chunk
                if len(content) > SIZE_LIMIT:
                    raise _RefusedError(413, f"the body is larger than {SIZE_LIMIT} bytes")
    except TimeoutError:
        raise _RefusedError(408, f"the body did not arrive within {HEADER_TIMEOUT:g} s") from None
    return bytes(content)


class RestServer:
    """Serves `signals_app` on its own thread while it is open.

    A refused request is counted, and logged and recorded once a minute. `Net.inspect` shows the server's
    state.

    Parameters
    ----------
    net : Net
        The net.
    host : str
        Address to listen on; with 127.0.0.1, other machines have no access.
    port : int
        Port to listen on; 0: any free one.
    hosts : iterable of str
        Host names of this server, besides `host`, IP addresses and ``localhost``.
    credentials : Credentials, optional
        Token that each request must contain. Without it, every program that can connect to the server can set
        signals; on 127.0.0.1, these are all programs of this machine.
    tls : Tls, optional
        Certificate for ``https``; with a `ca`, clients need a certificate, too.

    Raises
    ------
    DinerosError
        The packages starlette and uvicorn are not installed, the credentials have no token, or the
        certificate cannot be used.
    """

    def __init__(
        self,
        net: Net,
        *,
        host: str = "127.0.0.1",
        port: int = 8080,
        hosts: Iterable[str] = (),
        credentials: Credentials | None = None,
        tls: Tls | None = None,
    ) -> None:
        try:
            import uvicorn
        except ImportError as error:
            raise DinerosError("the package for the web server is not installed", hint=_MISSING) from error
        if credentials is not None and credentials.token is None:
            raise SecurityError("the credentials of a server must have a token")
        if credentials is None and not is_own_machine(host):
            LOG.warning(
                "everyone who can reach %s:%s can set the signals of %s: require a token", host, port, net.id
            )
        self._net = net
        self._host = host
        self._port = port
        self._scheme = "http" if tls is None else "https"
        self._source = net.new_source(f"rest server {host}:{port}")
        app = signals_app(
            net,
            hosts=[host, *hosts],
            token=credentials.token if credentials is not None else None,
            source=self._source,
        )
        clients, protocol = UnknownClients(LOG), _impatient_protocol()
        config: Any = uvicorn.Config(
            app,
            host=host,
            port=port,
            http=(
                counting_protocol(clients, protocol)
                if tls is None
                else handshaking_protocol(clients, protocol, tls.server_context(), HEADER_TIMEOUT)
            ),
            backlog=BACKLOG,
            ws="none",
            lifespan="off",
            log_config=None,
            log_level="error",  # a warning for each malformed request would fill the log
            access_log=False,
            server_header=False,
            timeout_graceful_shutdown=1,
        )
        self._server: Any = uvicorn.Server(config)
        self._thread = threading.Thread(target=self._serve, name="dineros rest", daemon=True)

    def _serve(self) -> None:
        try:
            asyncio.run(self._serving())
        except SystemExit:  # raised by uvicorn if the port is taken
            LOG.error("cannot listen on %s:%s", self._host, self._port)
        except Exception as error:
            self._source.fail("the rest server ends", f"{type(error).__name__}: {error}")
        self._source.connected(False)

    async def _serving(self) -> None:
        asyncio.get_running_loop().set_exception_handler(log_in_lines(LOG, "the rest server"))
        await self._server.serve()

    @property
    def url(self) -> str:
        """URL of the server, such as ``http://127.0.0.1:8080``; only while it is open."""
        port = self._server.servers[0].sockets[0].getsockname()[1]
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"{self._scheme}://{host}:{port}"

    def open(self, timeout: float = 10.0) -> None:
        """Start the server.

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
                self._net.remove_source(self._source)
                raise DinerosError(
                    f"cannot listen on {self._host}:{self._port}",
                    hint="another program may use the port",
                )
            time.sleep(0.01)
        self._source.connected(True)

    def close(self) -> None:
        """Stop the server."""
        self._server.should_exit = True
        join(self._thread, 10)
        self._net.remove_source(self._source)

    def __enter__(self) -> RestServer:
        self.open()
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _impatient_protocol() -> type[H11Protocol]:
    """Return uvicorn's protocol with a time limit for the head of a request."""
    from uvicorn.protocols.http.h11_impl import H11Protocol

    class ImpatientProtocol(H11Protocol):
        """Closes a connection without a complete request head."""

        def connection_made(self, transport: Any) -> None:
            super().connection_made(transport)
            self._known: Any = None
            self._patience = self.loop.call_later(HEADER_TIMEOUT, self._look)

        def connection_lost(self, exc: Exception | None) -> None:
            self._patience.cancel()
            super().connection_lost(exc)

        def _look(self) -> None:
            cycle = self.cycle
            if cycle is self._known and (cycle is None or cycle.response_complete):
                self.transport.close()
                return
            self._known = cycle
            self._patience = self.loop.call_later(HEADER_TIMEOUT, self._look)

    return ImpatientProtocol
