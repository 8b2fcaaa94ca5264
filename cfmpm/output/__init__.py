"""What a run leaves: history, fields, checkpoint, summary."""
