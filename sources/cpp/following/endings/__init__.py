"""How loops in C++ end: by their own progress, by what other code does, or in a way that is not known."""
