"""The compiled loops: tiles of lanes, and the numbers of Systems lowered to them."""
