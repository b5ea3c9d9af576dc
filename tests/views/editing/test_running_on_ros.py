"""An application that is run on ROS 2 from the page: real nodes, which the page follows and ends."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import expect

from dineros.metamodel.files import save
from tests.support.programs.on_ros import on_ros
from tests.support.systems.talker import talker
from tests.views.browser import Visit, wait_until
from tests.views.editing.conftest import Edit
from tests.views.editing.driving import Hand

NewVisit = Callable[..., Visit]

PATIENCE = 240.0
"""Seconds: the first run on a machine builds the interfaces."""

HANDLERS = """
import logging

def configure(net):
    if net.id == "listener":
        @net.handler("Listen")
        def listen(firing):
            logging.getLogger("listener").info("heard a word")
            print("it was heard", flush=True)
"""


def nodes_of(domain: int) -> list[str]:
    """Return the command lines of processes that speak in a domain."""
    wanted = f"ROS_DOMAIN_ID={domain}".encode()
    found = []
    for folder in Path("/proc").iterdir():
        try:
            if folder.name.isdigit() and wanted in (folder / "environ").read_bytes().split(b"\0"):
                found.append((folder / "cmdline").read_bytes().replace(b"\0", b" ").decode())
        except OSError:  # it has ended, or is none of ours
            continue
    return [line for line in found if "dineros" in line]


@pytest.mark.long
def test_a_run_on_ros_is_followed_in_the_page_and_leaves_nothing(
    tmp_path: Path, edit: Edit, visit: NewVisit
) -> None:
    model = talker()
    model.pages[0].signals[0].initial = True  # type: ignore[attr-defined]
    save(model, tmp_path / "talker.sym.xmi")
    (tmp_path / "handlers.py").write_text(HANDLERS)
    one = visit()
    with on_ros() as domain:
        _, handle = edit(tmp_path / "talker.sym.xmi")
        hand = Hand(one.page, handle.url)
        page = hand.page
        page.locator("#work summary").first.click()
        page.get_by_role("button", name="Run…").click()
        page.locator("#dialog [name=how]").select_option("ros")
        page.locator("#dialog [name=timeout]").fill(str(PATIENCE))
        page.locator("#dialog").get_by_role("button", name="Run", exact=True).click()
        log = "([...dinerosEditor.worker.jobs.values()][0]?.log ?? [])"
        wait_until(page, f"{log}.some((line) => line.includes('listener started'))", PATIENCE)
        page.get_by_role("button", name="Watch the run here").click()
        noted = "Object.values(dinerosEditor.player.game?.places ?? {}).at(-1) === 3"
        wait_until(page, noted, PATIENCE)  # while it runs
        wait_until(page, f"{log}.filter((line) => line === 'listener: it was heard').length === 3", PATIENCE)
        assert len([line for line in nodes_of(domain) if "node_main" in line]) == 2
        address = page.get_by_role("link", name="follow and steer it").get_attribute("href")
        assert address is not None
        steered = visit().page
        steered.goto(address)
        steered.get_by_role("button", name="Pause talker").click(timeout=PATIENCE * 1000)
        steered.get_by_role("button", name="Proceed talker").click(timeout=PATIENCE * 1000)
        steered.get_by_role("button", name="Pause talker").wait_for(timeout=PATIENCE * 1000)
        steered.get_by_role("switch", name="Button: true").click()
        steered.get_by_role("switch", name="Button: false").wait_for(timeout=PATIENCE * 1000)
        page.get_by_role("button", name="Cancel run (ROS 2)").click()
        wait_until(page, "document.querySelector('#job-1').dataset.state === 'cancelled'", PATIENCE)
        page.locator("#job-1 summary", has_text="Log").click()
        for said in ("talker started", "heard a word", "listener stopped"):
            expect(page.locator("#job-1 pre")).to_contain_text(said)
        assert [line for line in nodes_of(domain) if "javascript" not in line] == []
        page.get_by_role("button", name="End the game (p)").click()
        page.get_by_role("button", name="Play the run").click()
        wait_until(page, "document.body.dataset.game === 'on'")
        assert page.locator("#game .quiet").first.inner_text() == "run of listener, talker"
