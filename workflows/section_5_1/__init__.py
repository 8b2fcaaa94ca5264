"""Section 5.1 of the paper: the stationary edge crack, figures 4 to 7."""
