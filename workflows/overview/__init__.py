"""One page of the whole: each figure beside its claims."""
