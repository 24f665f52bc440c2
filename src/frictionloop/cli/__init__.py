"""The command line: one verb per job, parameters under the same dotted names as in Python."""

from frictionloop.cli.app import main

__all__ = ["main"]
