"""Linear solvers of the stiffness."""
