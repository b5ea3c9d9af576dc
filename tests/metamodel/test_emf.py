"""Our metamodels and models under the Eclipse Modeling Framework itself: its loader and its validation."""

import subprocess
from pathlib import Path

import pytest

from dineros.metamodel.generate import METAMODELS
from tests.support.programs.system_packages import needs

ROOT = Path(__file__).resolve().parents[2]
JARS = [Path(f"/usr/share/java/eclipse-emf-{part}.jar") for part in ("common", "ecore", "ecore-xmi")]

pytestmark = needs("libeclipse-emf-ecore-xmi-java", "default-jdk-headless")


def validate(*files: Path) -> subprocess.CompletedProcess[str]:
    metamodels = [ROOT / "metamodel" / f"{name}.ecore" for name in METAMODELS]
    program = Path(__file__).parent / "emf" / "EmfValidator.java"
    classpath = ":".join(map(str, JARS))
    return subprocess.run(
        ["java", "-cp", classpath, str(program), *map(str, metamodels), *map(str, files)],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.mark.long
def test_emf_accepts_the_metamodels_and_the_case_study() -> None:
    result = validate(ROOT / "case_study" / "sorting.sym.xmi")
    assert result.returncode == 0, result.stdout + result.stderr
    assert [line.split()[1] for line in result.stdout.splitlines()] == ["ok"] * (len(METAMODELS) + 1)


@pytest.mark.long
def test_the_check_can_fail(tmp_path: Path) -> None:
    """A model without a required reference: EMF names the feature."""
    broken = tmp_path / "broken.xmi"
    broken.write_text(
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<pn:Net xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" '
        'xmlns:pn="http://dineros.org/pn/1.0" id="n">'
        '<pages id="p"><arcs id="a"/></pages></pn:Net>'
    )
    result = validate(broken)
    assert result.returncode == 1
    assert "broken.xmi: PROBLEM" in result.stdout
    assert "source" in result.stdout
