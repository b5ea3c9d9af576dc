"""``tools/install`` and ``tools/system-packages`` on machines made up of a few commands."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.packaging.conftest import Machine

ROOT = Path(__file__).resolve().parents[2]


class TestInstall:
    @pytest.fixture
    def script(self, tmp_path: Path) -> Path:
        """A project of its own: whatever happens, this one's .venv is left alone."""
        project = tmp_path / "a project"
        (project / "tools").mkdir(parents=True)
        return Path(shutil.copy(ROOT / "tools/install", project / "tools/install"))

    def test_names_all_that_is_missing_in_one_line(self, machine: Machine, script: Path) -> None:
        done = machine.run(script)
        assert done.returncode == 1
        assert done.stdout == ""
        assert done.stderr == (
            "This machine lacks: Python 3.11 or 3.12 (python3 is not there, python3.12 is not there,"
            " python3.11 is not there; PYTHON=... names another); a C++ compiler (g++); cmake\n"
        )

    def test_refuses_other_versions_of_python(self, machine: Machine, script: Path) -> None:
        machine.python("python3", "3.13")
        machine.command("g++")
        machine.command("cmake")
        done = machine.run(script)
        assert done.returncode == 1
        assert "Python 3.11 or 3.12 (python3 is 3.13, python3.12 is not there" in done.stderr
        assert "g++" not in done.stderr

    def test_names_the_package_of_a_missing_venv_module(self, machine: Machine, script: Path) -> None:
        machine.python("python3", "3.12", "exit 1")
        machine.command("g++")
        machine.command("cmake")
        done = machine.run(script)
        assert done.returncode == 1
        assert done.stderr == (
            "This machine lacks: Python's venv module (Debian, Ubuntu: apt-get install python3.12-venv)\n"
        )

    def test_passes_over_a_python3_that_does_not_fit(self, machine: Machine, script: Path) -> None:
        machine.python("python3", "3.13")
        machine.python("python3.12", "3.12", f'echo "python3.12 $*" >>{machine.home}/calls')
        machine.command("g++")
        machine.command("cmake")
        machine.run(script)
        assert "python3.12 -m venv --clear .venv" in machine.calls

    def test_python_given_by_hand_is_the_only_one_tried(self, machine: Machine, script: Path) -> None:
        machine.python("python3", "3.12")
        machine.python("mine", "3.10")
        machine.command("g++")
        machine.command("cmake")
        done = machine.run(script, PYTHON="mine")
        assert done.returncode == 1
        assert done.stderr.startswith("This machine lacks: Python 3.11 or 3.12 (mine is 3.10; ")

    def test_a_broken_pip_ends_it(self, machine: Machine, script: Path) -> None:
        """A .venv whose pip fails must not be taken for a finished installation."""
        broken = "mkdir -p .venv/bin; cp {0}/venv-python .venv/bin/python"
        (machine.bin / "mkdir").symlink_to(shutil.which("mkdir") or "")
        (machine.bin / "cp").symlink_to(shutil.which("cp") or "")
        machine.python("python3", "3.12", broken.format(machine.bin))
        machine.python("venv-python", "3.12", "echo no network >&2; exit 1")
        machine.command("g++")
        machine.command("cmake")
        done = machine.run(script)
        assert done.returncode == 1
        assert "no network" in done.stderr

    def test_whatever_pip_fetches_has_a_locked_hash(self, machine: Machine, script: Path) -> None:
        machine.python("venv-python", "3.12", f'echo "$*" >>{machine.home}/calls')
        (script.parents[1] / ".venv/bin").mkdir(parents=True)
        (script.parents[1] / ".venv/bin/python").symlink_to(machine.bin / "venv-python")
        machine.python("python3", "3.12")
        machine.command("g++")
        machine.command("cmake")
        assert machine.run(script).returncode == 0
        fetching = [call for call in machine.calls if " install " in call and "--no-index" not in call]
        assert [call.split()[-1] for call in fetching] == [
            "requirements/build.txt",
            "requirements/development.txt",
        ]
        assert all("--require-hashes --no-deps" in call for call in fetching)
        (own,) = (call for call in machine.calls if "--editable ." in call)
        assert "--no-deps --no-build-isolation" in own, "nothing is fetched to build it either"


class TestSystemPackages:
    script = ROOT / "tools/system-packages"

    @pytest.fixture
    def wanted(self, tmp_path: Path) -> str:
        file = tmp_path / "list.txt"
        file.write_text(
            "# a remark\n\n"
            "graphviz  dot  class diagrams\n"
            f"here  {sys.executable}  nothing\n"
            "spin  /absent  model checks"  # no newline: the last line counts all the same
        )
        return str(file)

    @pytest.mark.parametrize("ci", ["", "1"])
    def test_says_nothing_when_all_is_there(self, machine: Machine, tmp_path: Path, ci: str) -> None:
        machine.command("dot")
        only = tmp_path / "one.txt"
        only.write_text("graphviz  dot  class diagrams\n")
        done = machine.run(self.script, str(only), CI=ci)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")

    def test_user_sees_the_command_and_what_is_skipped(self, machine: Machine, wanted: str) -> None:
        machine.command("apt-get", f'echo "apt-get $*" >>{machine.home}/calls')
        machine.command("id", "echo 1000")
        done = machine.run(self.script, wanted)
        assert done.returncode == 0
        assert done.stdout == (
            "System packages are missing. Install them with: sudo apt-get install graphviz spin\n"
            "  without graphviz, skipped: class diagrams\n"
            "  without spin, skipped: model checks\n"
        )
        assert machine.calls == []

    def test_ci_skips_nothing(self, machine: Machine, wanted: str) -> None:
        machine.command("apt-get")
        machine.command("id", "echo 1000")
        done = machine.run(self.script, wanted, CI="1")
        assert done.returncode == 1
        assert "sudo apt-get install graphviz spin" in done.stdout
        assert "nothing may be skipped" in done.stderr

    def test_root_installs_what_is_missing(self, machine: Machine, wanted: str) -> None:
        record = f'echo "apt-get $* ($DEBIAN_FRONTEND)" >>{machine.home}/calls'
        machine.command("apt-get", f"{record}; [ $1 = update ] || : >{machine.home}/installed")
        machine.command("id", "echo 0")
        text = Path(wanted).read_text().replace("/absent", f"{machine.home}/installed")
        Path(wanted).write_text(text.replace(" dot ", f" {machine.home}/installed "))
        done = machine.run(self.script, wanted, CI="1")
        assert done.returncode == 0
        assert done.stdout == (
            "Installing system packages with apt-get, which DINEROS_APT=no leaves out:"
            " graphviz (class diagrams); spin (model checks)\n"
        )
        assert machine.calls == [
            "apt-get update -qq (noninteractive)",
            "apt-get install -y -qq --no-install-recommends graphviz spin (noninteractive)",
        ]

    def test_root_reads_what_will_be_installed_before_it_is(self, machine: Machine, wanted: str) -> None:
        said = machine.home / "said"
        machine.command(
            "apt-get", f'while read -r line; do echo "$line"; done <{said} >{machine.home}/before'
        )
        machine.command("id", "echo 0")
        with said.open("wb") as output:
            subprocess.run(
                [self.script, wanted], env={"PATH": str(machine.bin)}, stdout=output, check=True, timeout=60
            )
        assert "graphviz (class diagrams); spin (model checks)" in (machine.home / "before").read_text()

    @pytest.mark.parametrize("answer", ["no", "0", "false"])
    def test_root_who_wants_no_packages_gets_none(self, machine: Machine, wanted: str, answer: str) -> None:
        machine.command("apt-get", f'echo "apt-get $*" >>{machine.home}/calls')
        machine.command("id", "echo 0")
        done = machine.run(self.script, wanted, DINEROS_APT=answer)
        assert done.returncode == 0
        assert done.stdout == (
            "System packages are missing. Install them with: sudo apt-get install graphviz spin\n"
            "  without graphviz, skipped: class diagrams\n"
            "  without spin, skipped: model checks\n"
        )
        assert machine.calls == []
        assert machine.run(self.script, wanted, DINEROS_APT=answer, CI="1").returncode == 1

    def test_root_without_network_goes_on_but_says_so(self, machine: Machine, wanted: str) -> None:
        machine.command("apt-get", "echo 'E: no network' >&2; exit 100")
        machine.command("id", "echo 0")
        done = machine.run(self.script, wanted)
        assert done.returncode == 0
        assert "without graphviz, skipped" in done.stdout
        assert "no network" in done.stderr
        assert machine.run(self.script, wanted, CI="1").returncode == 1

    def test_machines_without_apt_get_are_told_the_names(self, machine: Machine, wanted: str) -> None:
        machine.command("id", "echo 0")
        done = machine.run(self.script, wanted)
        assert done.returncode == 0
        assert done.stdout.startswith("System packages are missing (Debian's names): graphviz spin\n")

    def test_each_line_of_the_real_list_has_a_proof_and_a_reason(self) -> None:
        for line in (ROOT / "tools/system-packages.txt").read_text().splitlines():
            if line and not line.startswith("#"):
                assert len(line.split(maxsplit=2)) == 3, line


def test_scripts_can_be_started() -> None:
    for script in [
        ".ci/run",
        "tools/browser-packages",
        "tools/check-browser",
        "tools/install",
        "tools/system-packages",
    ]:
        assert os.access(ROOT / script, os.X_OK), script
