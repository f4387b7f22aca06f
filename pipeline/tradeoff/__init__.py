"""Studies of a scene: speed against accuracy, and how far each input moves the boundary."""
