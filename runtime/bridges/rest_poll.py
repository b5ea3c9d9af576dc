"""A client that polls web servers for the values of signals."""

from __future__ import annotations

import asyncio
import base64
import contextlib
import threading
from collections.abc import Mapping
from typing import Any
from urllib.parse import unquote

from dineros.metamodel.errors import DinerosError
from dineros.runtime.bridges.security import LOG, Credentials, SecurityError, Tls, is_own_machine, shown_url
from dineros.runtime.bridges.values import SIZE_LIMIT, SignalValueError, read_setting
from dineros.runtime.nets.signals import Signal
from dineros.runtime.nets.sources import Source
from dineros.runtime.nodes.net import Net
from dineros.runtime.scheduling.threads import join


class RestPoll:
    """Polls web servers for the values of signals while it is open.

    Each valid response resets the time of `Signal.stale_after`. A response that is late or not a truth value
    changes nothing; it is counted, and logged and recorded once a minute. Servers are polled concurrently, so
    that a slow one does not delay others. Redirects are not followed; compressed and large responses are not
    read. `Net.inspect` shows its state.

    Parameters
    ----------
    net : Net
        The net.
    urls : mapping of str to str
        Id or name of a signal -> URL of its value, as JSON ``{"value": true}`` or as plain text. Credentials
        before an ``@`` and the query after a ``?`` are sent to the server, but not logged or recorded.
    period : float
        Seconds between requests.
    timeout : float
        Maximum time in seconds from the start of a request to the end of its response.
    credentials : Credentials, optional
        A token, or a name and password, for all of these servers.
    tls : Tls, optional
        For ``https``: trusted authorities and the client's certificate; by default the system's authorities.

    Raises
    ------
    UnknownElementError
        The net has no such signal.
    DinerosError
        The package httpx is not installed, or a URL or certificate cannot be used.
    """

    def __init__(
        self,
        net: Net,
        urls: Mapping[str, str],
        *,
        period: float = 1.0,
        timeout: float = 5.0,
        credentials: Credentials | None = None,
        tls: Tls | None = None,
    ) -> None:
        try:
            import httpx  # noqa: F401
        except ImportError as error:
            raise DinerosError(
                "the package for the web client is not installed", hint="install dineros[rest]"
            ) from error
        self._net = net
        self._questions = [_Question(net.signal(name), url, credentials) for name, url in urls.items()]
        self._period = period
        self._timeout = timeout
        self._context = _context(tls, any(each.url.startswith("https") for each in self._questions))
        self._ending = threading.Event()
        self._running: tuple[asyncio.AbstractEventLoop, asyncio.Task[Any]] | None = None
        self._thread: threading.Thread | None = None
        self._sources: list[Source] = []

    def open(self) -> None:
        """Start polling."""
        self._ending.clear()
        self._sources = [self._net.new_source(f"rest {each.shown}") for each in self._questions]
        self._thread = threading.Thread(target=self._run, name="dineros rest poll", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop polling."""
        self._ending.set()
        if self._running is not None:
            loop, task = self._running
            with contextlib.suppress(RuntimeError):  # its event loop has just ended
                loop.call_soon_threadsafe(task.cancel)
        join(self._thread, 10)
        for source in self._sources:
            self._net.remove_source(source)

    def __enter__(self) -> RestPoll:
        self.open()
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _run(self) -> None:
        """Poll until `close`."""
        with contextlib.suppress(asyncio.CancelledError):
            asyncio.run(self._ask_all())

    async def _ask_all(self) -> None:
        task = asyncio.current_task()
        assert task is not None
        self._running = asyncio.get_running_loop(), task
        if self._ending.is_set():
            return
        await asyncio.gather(
            *(
                self._ask_again(question, source)
                for question, source in zip(self._questions, self._sources, strict=True)
            )
        )

    async def _ask_again(self, question: _Question, source: Source) -> None:
        import httpx

        async with httpx.AsyncHTTPTransport(verify=self._context) as transport:
            while True:
                try:
                    async with asyncio.timeout(self._timeout):
                        value = read_setting(await question.ask(transport), question.signal.values)
                    source.connected(True)
                    source.accept()
                    question.signal.set(value, f"rest {question.shown}")
                except TimeoutError:
                    self._failed(question, source, f"no answer in {self._timeout:g} s")
                except (SignalValueError, httpx.TransportError) as error:
                    self._failed(question, source, str(error) or type(error).__name__)
                except Exception as error:  # no response of a server may end the bridge
                    self._failed(question, source, f"{type(error).__name__}: {error}")
                await asyncio.sleep(self._period)

    @staticmethod
    def _failed(question: _Question, source: Source, error: str) -> None:
        source.connected(False)
        what = "value" if question.signal.values else "truth value"
        source.fail(question.shown, f"gives no {what}: {question.redacted(error)}")


class _Question:
    """A signal with the URL to poll."""

    def __init__(self, signal: Signal, url: str, credentials: Credentials | None) -> None:
        import httpx

        self.signal = signal
        try:
            self.shown = shown_url(url)
            address = httpx.URL(url)
        except (httpx.InvalidURL, ValueError):
            raise SecurityError(f"the address for the signal {signal.id} is invalid") from None
        if address.scheme not in ("http", "https") or not address.host:
            raise SecurityError(f"the address for the signal {signal.id} must begin with http or https")
        info = address.userinfo.decode("ascii")
        self._secrets = [text for text in (info, unquote(info), address.query.decode("ascii")) if text]
        if info:
            name, _, password = info.partition(":")
            credentials = Credentials(unquote(name) or None, unquote(password) or None)
        self._headers = {"Accept-Encoding": "identity", "User-Agent": "dineros"}
        if credentials is not None:
            self._headers["Authorization"] = _authorization(credentials)
            if address.scheme == "http" and not is_own_machine(address.host):
                LOG.warning("credentials for %s are sent unencrypted: use https", self.shown)
        self.url = str(address.copy_with(userinfo=b"", fragment=None))

    async def ask(self, transport: Any) -> bytes:
        """Return the body of the response; an error if it is too large, compressed, or not a success."""
        import httpx

        # Without httpx's client, which logs URLs, keeps cookies and follows redirects.
        answer = await transport.handle_async_request(httpx.Request("GET", self.url, headers=self._headers))
        try:
            if answer.is_redirect:
                raise SignalValueError(
                    f"it redirects ({answer.status_code}), which is not followed",
                    hint="use the final address",
                )
            if not answer.is_success:
                raise SignalValueError(f"it answers {answer.status_code}")
            if answer.headers.get("Content-Encoding", "identity").lower() != "identity":
                raise SignalValueError("its answer is compressed, which was not asked for")
            content = bytearray()
            async for chunk in answer.stream:
                content += chunk
                if len(content) > SIZE_LIMIT:
                    raise SignalValueError(f"its answer is larger than {SIZE_LIMIT} bytes")
            return bytes(content)
        finally:
            await answer.aclose()

    def redacted(self, text: str) -> str:
        """Return a text without the secret parts of the URL."""
        for secret in self._secrets:
            text = text.replace(secret, "***")
        return text


def _authorization(credentials: Credentials) -> str:
    if credentials.token is not None:
        return f"Bearer {credentials.token}"
    pair = f"{credentials.username or ''}:{credentials.password or ''}"
    return f"Basic {base64.b64encode(pair.encode()).decode()}"


def _context(tls: Tls | None, is_needed: bool) -> Any:
    import ssl

    if tls is not None:
        return tls.client_context()
    return Tls().client_context() if is_needed else ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
