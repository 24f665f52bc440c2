"""One kind of entry of a project each."""
