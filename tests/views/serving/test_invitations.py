"""The address on a browser's command line: all users can read it, it works once, for this user."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest

from dineros.views.serving import invitations
from dineros.views.serving.handle import PageHandle
from tests.views.serving.small_page import serve_small_page


@pytest.fixture
def page() -> Iterator[PageHandle]:
    handle = serve_small_page()
    yield handle
    handle.stop()


def fetch(url: str, **headers: str) -> tuple[int, str]:
    """Return the status, and where it was found in the end or what it says."""
    try:
        with urlopen(Request(url, headers=headers), timeout=10) as answer:
            return answer.status, answer.url
    except HTTPError as error:
        return error.code, error.read().decode()


def test_it_leads_to_the_page_once(page: PageHandle) -> None:
    url = page.url_for_command_line()
    assert page.url.partition("token=")[2] not in url
    assert fetch(url) == (200, page.url)
    status, text = fetch(url)
    assert status == 403 and "works once" in text
    assert fetch(page.url_for_command_line()) == (200, page.url)


def test_it_is_refused_to_other_names_and_later(page: PageHandle, monkeypatch: pytest.MonkeyPatch) -> None:
    url = page.url_for_command_line()
    assert fetch(url, Host="evil.example")[0] == 403
    assert fetch(url) == (200, page.url)
    assert fetch(f"{page.url.partition('?')[0]}?code=")[0] == 403
    monkeypatch.setattr(invitations, "VALID", -1.0)
    assert fetch(page.url_for_command_line())[0] == 403


def test_it_is_refused_to_other_users(page: PageHandle, monkeypatch: pytest.MonkeyPatch) -> None:
    url = page.url_for_command_line()
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    assert fetch(url)[0] == 403
    monkeypatch.undo()
    assert fetch(url) == (200, page.url)  # the user's browser comes later


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can be somebody else")
def test_another_user_of_the_machine_gets_nothing(page: PageHandle) -> None:
    url = page.url_for_command_line()
    host, _, path = url.removeprefix("http://").partition("/")
    ask = (
        f"exec 3<>/dev/tcp/{host.replace(':', '/')}; "
        f"printf 'GET /%s HTTP/1.1\\r\\nHost: {host}\\r\\n\\r\\n' '{path}' >&3; head -1 <&3"
    )
    done = subprocess.run(["bash", "-c", ask], check=True, user=65534, stdout=subprocess.PIPE, text=True)
    assert " 403 " in done.stdout
    assert fetch(url) == (200, page.url)


def test_edit_gives_the_browser_no_token(tmp_path: Path) -> None:
    browser = tmp_path / "browser"
    seen = tmp_path / "seen"
    browser.write_text(f'#!/bin/sh\ntr "\\0" "\\n" </proc/$$/cmdline >{seen}.new\nmv {seen}.new {seen}\n')
    browser.chmod(0o700)
    environment = {**os.environ, "BROWSER": str(browser), "XDG_STATE_HOME": str(tmp_path / "state")}
    main = "from dineros.cli.main import main; main()"
    editor = subprocess.Popen(
        [sys.executable, "-P", "-c", main, "edit", "new.sym.xmi"],
        cwd=tmp_path,
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert editor.stdout is not None
        printed = editor.stdout.readline().split()[-1]
        while not seen.exists():
            assert editor.poll() is None
        arguments = seen.read_text()
        assert printed.partition("token=")[2] not in arguments
        assert fetch(arguments.split()[-1]) == (200, printed)
    finally:
        editor.kill()
        editor.communicate()
