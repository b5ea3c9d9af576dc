"""A page of the editor, as far as the server can tell: what it says, is told, and knows then."""

from __future__ import annotations

import json
from contextlib import ExitStack
from types import TracebackType
from typing import Any

from websockets.sync.client import connect
from websockets.typing import Origin

from dineros.views.serving.handle import PageHandle


class PageModel:
    """What a page knows of the model, by the messages it got."""

    def __init__(self) -> None:
        self.said: list[dict[str, Any]] = []
        self.model: dict[str, Any] = {}
        self.marks: dict[str, Any] = {}
        self.state: dict[str, Any] = {}
        self.revision = -1

    def told(self, text: str | bytes) -> dict[str, Any]:
        """Take a message in."""
        message: dict[str, Any] = json.loads(text)
        self.said.append(message)
        match message["type"]:
            case "snapshot":
                self.model, self.marks = message["model"], message["marks"]
                self.state, self.revision = message["state"], message["revision"]
            case "change":
                assert message["revision"] == self.revision + 1
                self.revision, self.state = message["revision"], message["state"]
                for handle, found in message["objects"].items():
                    if found is None:
                        self.model["objects"].pop(handle, None)
                    else:
                        self.model["objects"][handle] = found
            case "marks":
                self.marks = message["marks"]
            case "state":
                self.state = message["state"]
        return message

    def by_id(self, id: str) -> str:
        """Return the handle of the element with an id."""
        objects = self.model["objects"].items()
        found: str = next(handle for handle, each in objects if each.get("values", {}).get("id") == id)
        return found


class Tab(PageModel):
    """A tab of a browser without a browser.

    Parameters
    ----------
    handle : PageHandle
        The editor.
    name : str
        By what the server knows the tab.
    """

    def __init__(self, handle: PageHandle, name: str) -> None:
        super().__init__()
        origin = handle.url.split("/?")[0]
        address = f"{handle.url.replace('http', 'ws', 1).replace('/?', '/commands?')}&tab={name}"
        self._open = ExitStack()
        self._socket = self._open.enter_context(connect(address, origin=Origin(origin), max_size=1 << 26))
        self._number = 0
        assert self.hear()["type"] == "snapshot"

    def __enter__(self) -> Tab:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._open.close()

    def hear(self) -> dict[str, Any]:
        """Wait for a message."""
        return self.told(self._socket.recv(timeout=20))

    def send(self, text: str | bytes) -> None:
        """Say something, whatever it is."""
        self._socket.send(text)

    def ask(self, ask: str, **more: Any) -> dict[str, Any]:
        """Ask for something; return the answer."""
        self._number += 1
        self.send(json.dumps({"number": self._number, "ask": ask, **more}))
        return self.answer(self._number)

    def answer(self, number: int | None) -> dict[str, Any]:
        """Wait for the answer to what has a number."""
        while True:
            message = self.hear()
            if message["type"] in ("done", "refused") and message["number"] == number:
                return message

    def catch_up(self, revision: int) -> None:
        """Wait until the model is at a revision."""
        while self.revision < revision:
            self.hear()
