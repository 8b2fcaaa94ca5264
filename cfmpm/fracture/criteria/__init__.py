"""Criteria of fracture, one file each; the words for them stand in `registry.criteria`."""
