"""Run time against error and against size."""
