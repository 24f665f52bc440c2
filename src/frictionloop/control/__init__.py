"""Control laws and the lookup table, one step function each."""
