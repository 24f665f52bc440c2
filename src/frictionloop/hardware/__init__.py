"""What one builds: the plate and its drive, the force sensor and its electronics. Knows no loop."""
