"""One point of the diagram: loading with wear and friction heat."""
