"""What others have computed, and independent FEM codes to compare with."""
