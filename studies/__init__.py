"""What supports statements of frictionloop and serves no user's call: one command each, see README.md."""
