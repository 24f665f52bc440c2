"""What the finger and the plate do: friction law, plate envelope, disturbances."""
