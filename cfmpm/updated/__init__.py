"""The updated Lagrangian formulation: a grid that is reset after every load step (paper step 9)."""
