"""The same bits from the Cortex-M7 at every level of optimisation as from this machine."""

import hashlib

import numpy as np
import pytest

from frictionloop.device.emulator import TeensyEmulator
from frictionloop.device.emulator.budget import edges, heartbeat, opening, strokes
from frictionloop.device.emulator.peripherals import converted
from frictionloop.device.simulated_boards import HostBoard, Sample

pytest.importorskip("unicorn", reason="install frictionloop[emulator]")

PERIOD = 2870
LAWS = ["pi", "lookup", "notch_pi", "limit_observer"]
TICKS = [pytest.param(1000, marks=pytest.mark.slow), pytest.param(4000, marks=pytest.mark.soak)]


def corpus(ticks):
    """Samples, and the bytes that come with some; edges come between strokes, so that the loop is closed in them."""
    stroke, edge = list(strokes(ticks, seed=5)), list(edges(ticks, seed=6))
    rng = np.random.default_rng(7)
    for k in range(ticks):
        start = opening()[40 * k : 40 * k + 40]
        yield edge[k] if rng.random() < 0.02 else stroke[k], start or (heartbeat(9 + k) if k % 500 == 499 else b"")


@pytest.mark.parametrize("ticks", TICKS)
@pytest.mark.parametrize("law", LAWS)
def test_levels_of_optimisation_and_the_host_agree(law, ticks, images, law_words):
    digests = {}
    host, digest, used = HostBoard(law_words[law]), hashlib.sha256(), set()
    pending = b""
    for k, ((force, load, position), data) in enumerate(corpus(ticks)):
        duty = host.tick(Sample(*map(converted, (*force, position, load))), 200 * k).duty
        compare = (2 * duty * PERIOD + 2**17 - 1) // 2**18
        used.add(compare)
        digest.update(compare.to_bytes(2, "little"))
        pending = data
        if pending:
            host.receive(pending, 200 * k + 300)
        host.transmit(200 * k + 300)
    digests["host"] = digest.hexdigest()
    assert len(used) > 30
    for optimise in (None, "0", "2", "s"):
        teensy, digest = TeensyEmulator(images(law, optimise=optimise).elf), hashlib.sha256()
        for (force, load, position), data in corpus(ticks):
            teensy.receive(data)
            teensy.tick(force, load, position)
            digest.update(teensy.compare.to_bytes(2, "little"))
        digests[f"Cortex-M7 -O{optimise or 'default'}"] = digest.hexdigest()
    assert len(set(digests.values())) == 1, digests
