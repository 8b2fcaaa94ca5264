"""Parameter studies by rules."""
