"""Loads and supports as nodal values: a file for each kind, in the table `registry.loads`."""
