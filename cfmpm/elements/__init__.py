"""Background elements: one record of plain numbers for each, in a file of its own."""
