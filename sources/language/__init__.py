"""An interpreter of Python over partly known values: nothing is executed or imported."""
