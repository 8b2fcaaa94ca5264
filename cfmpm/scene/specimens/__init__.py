"""Families of specimens, one module each; `registry.specimens` lists them."""
