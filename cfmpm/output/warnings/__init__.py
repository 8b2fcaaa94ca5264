"""Warnings of a run: which of its results are doubtful, why, and what to change."""
