"""Pages run their own scripts and no others, whatever gets into them."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from dineros.metamodel.files import load
from dineros.views.nets import save_picture, view_of
from dineros.views.reports.check_report import CheckContent, check_page
from dineros.views.serving.handle import PageHandle
from dineros.views.traces.coding import TraceCoder
from dineros.views.traces.net_pane import net_content
from dineros.views.traces.page import trace_page
from tests.support.systems.talker import talker
from tests.views.browser import Visit, wait_until
from tests.views.live.conftest import own_state, serve
from tests.views.samples import CASE_STUDY, lasso, save_run
from tests.views.traces.test_building import built

__all__ = ["own_state", "serve"]  # fixtures

INJECTED = """() => {
  window.ran = [];
  const add = (tag, features) => document.body.append(Object.assign(document.createElement(tag), features));
  add("script", { textContent: "window.ran.push('script')" });
  document.body.insertAdjacentHTML("beforeend", `<img src="data:," onerror="window.ran.push('handler')">`);
  add("script", { src: "data:text/javascript,window.ran.push('data')" });
  add("script", { src: "http://127.0.0.1:9/evil.js" });
  const frame = document.createElement("iframe");
  const loaded = new Promise((done) => frame.addEventListener("load", done));
  document.body.append(Object.assign(frame, { srcdoc: "<script>parent.ran.push('frame')</script>" }));
  add("a", { href: "javascript:window.ran.push('link')", id: "evil" });
  document.getElementById("evil").click();
  return loaded.then(() => null);
}"""


def nothing_else_runs(one: Visit) -> None:
    """Put scripts into a page in every way there is; none may run, nor be fetched."""
    one.page.evaluate(INJECTED)
    one.page.wait_for_timeout(300)
    assert one.page.evaluate("window.ran") == []
    refusals = [problem for problem in one.problems if "Content Security Policy" in problem]
    assert any("evil.js" in refusal for refusal in refusals), one.problems
    one.problems[:] = [problem for problem in one.problems if problem not in refusals]


def page_of_a_net(folder: Path) -> tuple[Path, str]:
    save_picture(view_of(talker()), folder / "net.html")
    return folder / "net.html", "Number(document.body.dataset.ready) >= 1"


def page_of_a_trace(folder: Path) -> tuple[Path, str]:
    view = TraceCoder(built(lasso()), "sample").snapshot()
    content = {"view": view, "net": net_content(load(CASE_STUDY))}
    (folder / "trace.html").write_text(trace_page(content, title="sample"), encoding="utf-8")
    return folder / "trace.html", "globalThis.dinerosTrace && dinerosTrace.view.frames > 0"


def page_of_a_check(folder: Path) -> tuple[Path, str]:
    content = CheckContent(title="sample", source="sample", findings=[], proved=["all"], unknown=[])
    (folder / "report.html").write_text(check_page(content)[0], encoding="utf-8")
    return folder / "report.html", "true"


@pytest.mark.parametrize("made", [page_of_a_net, page_of_a_trace, page_of_a_check])
def test_files_run_nothing_else(
    visit: Callable[..., Visit], tmp_path: Path, made: Callable[[Path], tuple[Path, str]]
) -> None:
    file, ready = made(tmp_path)
    one = visit()
    one.page.goto(file.as_uri())
    wait_until(one.page, ready)
    assert one.problems == []
    nothing_else_runs(one)


def test_the_live_page_runs_nothing_else(
    visit: Callable[..., Visit], tmp_path: Path, serve: Callable[..., PageHandle]
) -> None:
    handle = serve(save_run(tmp_path / "run"))
    one = visit()
    answer = one.page.goto(handle.url)
    wait_until(one.page, "globalThis.dinerosTrace && dinerosTrace.view.frames > 0")
    assert one.problems == []
    assert answer is not None
    policy = answer.headers["content-security-policy"]
    assert "frame-ancestors 'none'" in policy
    assert "'unsafe-inline'" not in policy.partition("style-src")[0]
    nothing_else_runs(one)


def test_a_page_holds_what_names_hold(visit: Callable[..., Visit], tmp_path: Path) -> None:
    net = talker()
    net.name = "</script><script>window.ran = true</script>"
    save_picture(view_of(net), tmp_path / "net.html")
    one = visit()
    one.page.goto((tmp_path / "net.html").as_uri())
    wait_until(one.page, "Number(document.body.dataset.ready) >= 1")
    assert one.page.evaluate("window.ran") is None
    assert json.loads(one.page.inner_text("#view"))["title"] == net.name
