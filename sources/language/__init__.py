"""An interpreter of Python over values that are partly known: nothing is executed or imported."""
