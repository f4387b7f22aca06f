"""Studies of a scene: speed against accuracy, and the boundary against each input."""
