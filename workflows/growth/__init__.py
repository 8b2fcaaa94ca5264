"""Sections 5.2 to 5.5 of the paper: growing cracks, figures 9 to 16."""
