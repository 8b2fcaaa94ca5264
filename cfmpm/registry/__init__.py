"""Tables of the words of a scene that select code; other packages can add words."""
