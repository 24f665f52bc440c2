"""The plate: modes, drive, carrier, and how its amplitude follows."""
