"""Loads and supports as nodal values: one file for each kind; `registry.loads` lists them."""
