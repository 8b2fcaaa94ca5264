"""Parameter studies: one scene solved for many values of its keys, with results in one dataset."""
