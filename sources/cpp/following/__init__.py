"""The interpreter of C++: it follows the code symbolically and runs nothing."""
