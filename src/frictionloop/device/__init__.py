"""Talk to a board: frames and messages, byte pipes, and the device behind them."""
