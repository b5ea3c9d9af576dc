"""The token game: the net that is proved is fired, and shown on the model that it was made from."""

from dineros.views.editing.playing.desk import PlayingDesk

__all__ = ["PlayingDesk"]
