"""Normal contact of rough, elastic, perfectly plastic bodies."""
