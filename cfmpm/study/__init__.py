"""Parameter studies: one scene solved for many values of its keys, gathered into one dataset."""
