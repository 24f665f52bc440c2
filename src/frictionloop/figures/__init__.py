"""What every figure shares: one style, and drawing to files that are the same bytes every time."""
