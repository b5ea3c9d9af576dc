"""The packages of the case study's workspace can be imported, as the nodes do it."""

from __future__ import annotations

import sys
from pathlib import Path

WORKSPACE = Path(__file__).resolve().parents[2] / "case_study" / "workspace"

sys.path[:0] = [str(path) for path in sorted((WORKSPACE / "src").iterdir()) if path.is_dir()]
