"""Files of signals, read as samples of one channel."""
