"""The token game: fires the flattened net and shows it on the model."""

from dineros.views.editing.playing.desk import PlayingDesk

__all__ = ["PlayingDesk"]
