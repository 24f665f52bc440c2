"""The live page: slide on the plate, see and compare, in a browser."""
