"""How long what was recorded took: callbacks, handlers, periods of timers, messages on their way."""
