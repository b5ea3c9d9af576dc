"""Measures recorded times: callbacks, handlers, periods of timers, latencies of messages."""
