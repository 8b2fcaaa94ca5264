"""Criteria of crack growth, one file each; `registry.criteria` lists their words."""
