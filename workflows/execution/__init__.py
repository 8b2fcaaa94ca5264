"""What surrounds the jobs: their imports and logs, and what a killed run leaves."""
