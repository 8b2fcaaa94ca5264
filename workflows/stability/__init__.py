"""The stability study: what happens in extreme cases."""
