"""``python -m frictionloop``: the command line."""

from frictionloop.cli import main

if __name__ == "__main__":
    main()
