"""Fig. 8 of the paper: the plate of section 5.1 pulled to twice its length."""
