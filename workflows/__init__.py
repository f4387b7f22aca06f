"""Studies and scripts beside the shipped scenes."""
