"""The firmware's image, instruction by instruction, on a desk without a board."""

from frictionloop.device.emulator.teensy import TeensyEmulator

__all__ = ["TeensyEmulator"]
