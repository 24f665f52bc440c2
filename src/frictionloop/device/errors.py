"""What can go wrong with a device that the caller may want to tell apart."""

from __future__ import annotations

from frictionloop.quantities import FrictionloopError


class DeviceError(FrictionloopError):
    """A device that cannot be reached or does not do what it was asked for."""

    def __init__(self, said: str = "", code: str = "DEVICE-LOST") -> None:
        super().__init__(said, code)


class Unplugged(DeviceError):
    """The line is gone."""


class NoReply(DeviceError):
    """The line is there and the device says nothing."""


class Refused(DeviceError):
    """The device answered with a refusal: `reason` by name, `index` the word or point that is wrong, or None."""

    def __init__(self, words: str, reason: str, index: int | None) -> None:
        super().__init__(words, "DEVICE-REFUSED")
        self.reason, self.index = reason, index
