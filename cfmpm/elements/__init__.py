"""Background elements: one record of plain data for each, in its own module."""
