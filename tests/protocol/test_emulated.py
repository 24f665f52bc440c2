"""The image that would be flashed, at a simulated bench, through the calls that a board on the desk takes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.laws import LAWS
from frictionloop.firmware.image import build
from frictionloop.firmware.image_law import board_law
from frictionloop.firmware.parameter_words import firmware_words

SYSTEM = fl.bench().evolve(fl.RETUNED | {"sensor.adc_bits": 12})


@pytest.mark.slow
def test_the_image_does_what_the_library_does(tmp_path: Any) -> None:
    image = build("teensy41", firmware_words(SYSTEM).tolist(), board_law(LAWS["pi"]), tmp_path, rate_hz=5000)
    with fl.connect(f"emulated:{image.elf}", SYSTEM) as board, fl.connect("sim:", SYSTEM) as library:
        assert (board.info.board, board.info.revision) == ("teensy41", library.info.revision)
        assert board.system == SYSTEM
        run, same = board.run(0.5, 1.5), library.run(0.5, 1.5)
    assert (run.attrs["source"], run.attrs["lost_samples"]) == ("emulated", 0)
    # Requests take longer over its port, and its converters have 12 bits: the loop is the same, tick by tick it is not.
    shift, late = run.attrs["start_tick"] - same.attrs["start_tick"], slice(0.5, None)
    np.testing.assert_allclose(run.position.values[:5000], same.position.values[shift : 5000 + shift], atol=2e-5)
    errors = [float((x.f_a - x.f_r).where(x.sliding).sel(time=late).std()) for x in (run, same)]
    assert errors[0] == pytest.approx(errors[1], rel=0.1)
