"""Families of specimens, one file each; the words for them stand in `registry.specimens`."""
