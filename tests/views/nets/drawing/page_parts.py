"""What tests of a net's page look at."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dineros.views.nets import ViewModel, save_picture
from dineros.views.nets.placement.picture import Picture
from tests.views.browser import wait_until
from tests.views.nets.arranged import stands

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from tests.views.browser import Visit


def saved(view: ViewModel, folder: Path) -> Path:
    """Write the page of a view."""
    path = folder / f"{view.id}.html"
    save_picture(view, path)
    return path


def opened(one: Visit, file: Path, fragment: str = "") -> Page:
    """Open a page and wait until its net is drawn."""
    one.page.goto(file.as_uri() + fragment)
    drawn(one.page, 1)
    return one.page


def drawn(page: Page, times: int) -> None:
    """Wait until the picture was drawn so many times."""
    ready = f"Number(document.body.dataset.ready) >= {times} && !document.body.classList.contains('busy')"
    wait_until(page, ready)


def shown(page: Page) -> set[str]:
    """Return ids of the nodes and boxes that are drawn."""
    found: list[str] = page.evaluate(
        """[...document.querySelectorAll('#picture g[data-id]:not(.edge):not(.signal)')]
           .map((one) => one.dataset.id)"""
    )
    assert len(found) == len(set(found))
    return set(found)


def area(page: Page, id: str, inside: str = "") -> dict[str, float]:
    """Return where an element, or a part of it, is in the window."""
    found: dict[str, float] = page.evaluate(
        "(selector) => document.querySelector(selector).getBoundingClientRect().toJSON()",
        f'#picture [data-id="{id}"] {inside}',
    )
    return found


def marked(page: Page, how: str) -> set[str]:
    """Return ids of what is pointed out."""
    found: list[str] = page.evaluate(
        "(how) => [...document.querySelectorAll(`#picture .${how}`)].map((one) => one.dataset.id)", how
    )
    return set(found)


def scale(page: Page) -> float:
    """Return pixels of the window per unit of the picture."""
    wide = float(str(page.get_attribute("#picture", "viewBox")).split()[2])
    return float(page.evaluate("document.querySelector('#picture').clientWidth")) / wide


def positioned(page: Page) -> Picture:
    """Return what the page shows as a layout: boxes and nodes in the picture's coordinates."""
    found: Picture = page.evaluate(
        """() => {
          const boxes = [], nodes = [], number = (one, name) => Number(one.getAttribute(name));
          for (const group of document.querySelectorAll('#picture g[data-id]:not(.edge):not(.signal)')) {
            const id = group.dataset.id, frame = group.querySelector(':scope > .frame');
            if (frame) {
              const [x, y, width, height] = ['x', 'y', 'width', 'height'].map((name) => number(frame, name));
              boxes.push({id, collapsed: group.classList.contains('collapsed'), x, y, width, height});
            } else {
              const [x, y] = group.parentNode.getAttribute('transform').match(/-?[\\d.]+/g).map(Number);
              nodes.push({id, x, y});
            }
          }
          return {boxes, nodes};
        }"""
    )
    return found


def centres(page: Page) -> dict[str, tuple[float, float]]:
    """Return where elements stand in the picture."""
    return stands(positioned(page))
