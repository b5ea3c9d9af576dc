"""The portfolio: all methods of deciding, one scheduler, one record of what is known of a net."""
