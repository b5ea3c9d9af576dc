"""Editors that end with their test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from dineros.cli.commands.models.edit import own_program
from dineros.metamodel.editing import Document
from dineros.views.editing import serve_editor
from dineros.views.serving.handle import PageHandle

Edit = Callable[..., tuple[Document, PageHandle]]


@pytest.fixture(autouse=True)
def own_state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


@pytest.fixture
def edit() -> Iterator[Edit]:
    """Return what serves a file; the document may be looked at only while no page says anything."""
    started: list[tuple[Document, PageHandle]] = []

    def start(file: Path) -> tuple[Document, PageHandle]:
        document = Document(file)
        started.append((document, serve_editor(document, program=own_program())))
        return started[-1]

    yield start
    for document, handle in started:
        handle.stop()
        document.close()
