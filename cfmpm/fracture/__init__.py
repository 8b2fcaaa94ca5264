"""What happens at a crack tip."""
