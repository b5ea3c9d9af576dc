"""Check the locked packages for known vulnerabilities, with pip-audit.

If the advisory service cannot be reached, one line says so, and nothing fails.

Usage: ``make audit``, which brings pip-audit.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

UNREACHABLE = ("ConnectionError", "Connection refused", "Max retries exceeded", "Timeout", "timed out")


def main(program: str, *locks: str) -> int:
    """Print one line for each hole.

    Parameters
    ----------
    program
        The command ``pip-audit``.
    *locks
        Files with exact versions and hashes.

    Returns
    -------
    int
        0: none is known, or the database could not be reached; 1: some are known; 2: pip-audit failed.
    """
    command = [program, "--vulnerability-service", "osv", "--require-hashes", "--disable-pip"]
    command += ["--progress-spinner", "off", "--format", "json", *(f"--requirement={lock}" for lock in locks)]
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder, "report.json")
        done = subprocess.run([*command, f"--output={report}"], check=False, capture_output=True, text=True)
        if not report.exists():
            if any(word in done.stderr for word in UNREACHABLE):
                print("Not audited: the advisory service cannot be reached from here")
                return 0
            print(f"pip-audit failed:\n{done.stderr}", file=sys.stderr)
            return 2
        found = json.loads(report.read_text(encoding="utf-8"))["dependencies"]
    holes = [(package, hole) for package in found for hole in package.get("vulns", [])]
    for package, hole in holes:
        releases = ", ".join(hole["fix_versions"]) or "no release"
        print(f"{package['name']} {package['version']}: {hole['id']} (fixed in {releases})")
    for package in found:
        if "skip_reason" in package:
            print(f"{package['name']}: {package['skip_reason']}")
    print(f"{len(found)} packages, {len(holes)} known vulnerabilities")
    return 1 if holes else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
