"""The panels, a file each: ``show(state, seen)`` draws one and gives back what was chosen in it."""
