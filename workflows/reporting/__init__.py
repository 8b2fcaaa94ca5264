"""Pages and tables of claims."""
