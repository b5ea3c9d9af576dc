"""Modules of JavaScript as one script, without Node.js."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import pytest

from dineros.views.javascript.client import evaluate
from dineros.views.javascript.modules import linked, name_of

ENTRIES = (
    "edit/page.js",
    "net/layout/elk.js",
    "net/page.js",
    "net/layout/worker.js",
    "trace/figures/figure.js",
    "trace/live.js",
    "trace/main.js",
)
"""What pages run, and what Python asks V8 for."""


def write(folder: Path, **modules: str) -> Path:
    for name, text in modules.items():
        (folder / f"{name}.js").write_text(text)
    return folder


def value(script: str) -> object:
    return evaluate([], f"() => {script}")


def test_modules_run_once_after_those_they_import_from_and_keep_their_own_names(tmp_path: Path) -> None:
    write(
        tmp_path,
        entry='import { one, ran as before } from "./one.js";\nimport {\n  two,\n} from "./two.js";\n'
        "const own = 3;\nexport const all = () => [one(), two, own, before].join();\n",
        one='import { two } from "./two.js";\nlet own = 1;\nexport function one() {\n  return own + two;\n}\n'
        "export const ran = (globalThis.runs ??= []).join();\n",
        two='(globalThis.runs ??= []).push("two");\nconst own = 2;\nexport const two = own;\n',
    )
    assert value(f"{linked('entry.js', tmp_path)}.all()") == "3,2,3,two"


def test_modules_in_folders_are_found_beside_who_imports_them(tmp_path: Path) -> None:
    (tmp_path / "inner").mkdir()
    write(tmp_path, shared="export class Shared {}\n")
    write(
        tmp_path / "inner", entry='import { Shared } from "../shared.js";\nexport const own = Shared.name;\n'
    )
    assert value(f"{linked('inner/entry.js', tmp_path)}.own") == "Shared"


def test_circles_are_refused(tmp_path: Path) -> None:
    write(tmp_path, a='import { b } from "./b.js";\n', b='import { a } from "./a.js";\n')
    with pytest.raises(ValueError, match=r"each other: a\.js -> b\.js -> a\.js"):
        linked("a.js", tmp_path)


@pytest.mark.parametrize(
    "line",
    [
        "export default 1;",
        "export let changes = 1;",
        "export { a };",
        'export * from "./b.js";',
        'import b from "./b.js";',
        'import * as b from "./b.js";',
        'import "./b.js";',
        'import { b } from "elsewhere";',
    ],
)
def test_other_forms_are_refused(tmp_path: Path, line: str) -> None:
    write(tmp_path, a=f"const a = 1;\n{line}\n", b="export const b = 1;\n")
    with pytest.raises(ValueError, match=r"a\.js: unsupported form"):
        linked("a.js", tmp_path)


def test_modules_are_strict(tmp_path: Path) -> None:
    write(tmp_path, a="export const self = (function () { return String(this); })();\n")
    assert value(f"{linked('a.js', tmp_path)}.self") == "undefined"


def test_every_module_belongs_to_a_page_or_to_a_picture() -> None:
    static = Path(str(files("dineros.views") / "static"))
    modules = {path.relative_to(static).as_posix() for path in static.rglob("*.js")}
    reached = "\n".join(map(linked, ENTRIES))
    assert {path for path in modules if f"const {name_of(path)} = " in reached} == modules
