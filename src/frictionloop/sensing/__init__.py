"""What the controller gets to know: the force sensor and its measurement."""
