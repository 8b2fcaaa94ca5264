"""The workflow's configuration, checked before anything runs."""
