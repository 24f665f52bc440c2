"""The simulator: steps of all rooms composed, repeated over time, scored."""
