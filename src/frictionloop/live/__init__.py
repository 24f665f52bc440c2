"""What runs behind a live page: a finger that moves, open and closed loop at once, a session in real time."""
