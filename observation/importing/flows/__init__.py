"""The branches of callbacks, as far as variables of their node decide about them."""
