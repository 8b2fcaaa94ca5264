"""Tables of the words of a scene that stand for code: one line for each, open to other packages."""
