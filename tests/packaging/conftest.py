"""Machines made up of a few commands, for the scripts that set up and test the project."""

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

ORDINARY = ["bash", "env", "dirname", "sed", "cut", "rm"]


@dataclass
class Machine:
    """A folder that is all of PATH; its commands write what they were asked to the file ``calls``."""

    home: Path

    @property
    def bin(self) -> Path:
        return self.home / "bin"

    def command(self, name: str, script: str = "exit 0") -> None:
        file = self.bin / name
        file.unlink(missing_ok=True)
        file.write_text(f"#!{shutil.which('bash')}\n{script}\n")
        file.chmod(0o755)

    def python(self, name: str, version: str, script: str = "exit 0") -> None:
        """A Python that knows its version; `script` answers everything else."""
        self.command(name, f'case "$*" in *version_info*) echo {version};; *) {script};; esac')

    def run(self, script: Path, *arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [script, *arguments],
            env={"PATH": str(self.bin), "HOME": str(self.home), "LANG": "C.UTF-8", **variables},
            cwd=self.home,
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )

    @property
    def calls(self) -> list[str]:
        file = self.home / "calls"
        return file.read_text().splitlines() if file.exists() else []


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    made = Machine(tmp_path)
    made.bin.mkdir()
    for name in ORDINARY:
        found = shutil.which(name)
        assert found
        (made.bin / name).symlink_to(found)
    return made
