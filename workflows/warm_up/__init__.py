"""Kernels are compiled once, before the jobs that need them."""
