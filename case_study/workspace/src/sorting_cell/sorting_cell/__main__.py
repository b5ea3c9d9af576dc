"""Runs the cell: ``python -m sorting_cell``."""

import sys

from sorting_cell.simulator import main

sys.exit(main())
