"""What the verbs of device and firmware show, compared with the screens kept in tests/golden."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from golden import check_screen

import frictionloop as fl
from frictionloop.device import transport
from frictionloop.firmware import image
from frictionloop.loop.growing_file import Column, Spool

NEAR = {"controller.kp": 0, "controller.ki": 150, "drive.ceiling_um": 2}
RINGING = {"controller.kp": 0.04, "controller.ki": 90.0}
TICK = {"tick": 2600, "law": 500, "effect": 3100, "interrupts": 1700, "background": 1500}


def info():
    found = fl.device.info("sim:", fl.bench().evolve(RINGING))
    return replace(found, revision="0.2.0+REVISION")


def play():
    effect = {"controller.kind": "notch_pi", "setpoint.kind": "effect", "setpoint.effect": "rough"}
    return fl.device.play("sim:", fl.bench().evolve(effect), 0.2)


def recovered():
    spool = Spool(
        "run.h5", {"f_m": Column("f8", {"units": "N"})}, 2e-4, {"schema": 1, "source": "device"}, ("lost_samples",)
    )
    spool.append({"f_m": np.zeros(7000)}, {"lost_samples": 3})
    content = spool.partial.read_bytes()
    spool.drop()
    with open("run.partial-1a2b3c4d.h5", "wb") as left:
        left.write(content)
    return fl.device.recover("run.partial-1a2b3c4d.h5")


def law():
    return fl.firmware.law(fl.bench().evolve({"controller.kind": "notch_pi"}), "law.c")


def exported():
    strange = {"plate.frequency_hz": 38200.0, "plate.q": 2000.0, "motion.stroke_mm": 80.0, "board.ceiling_um": 0.3}
    return fl.firmware.export(fl.bench().evolve(strange), "table")


SITUATIONS = {
    "device-list": fl.device.list_ports,
    "device-info": info,
    "device-set": lambda: fl.device.configure("sim:", NEAR),
    "device-run": lambda: fl.device.run("sim:", fl.bench().evolve({"board.ceiling_um": 0.5}), 0.5),
    "device-play": play,
    "device-recover": recovered,
    "device-clear": lambda: fl.device.clear("sim:"),
    "firmware-export": exported,
    "firmware-build": lambda: fl.firmware.build(fl.bench(), "image", trace=lambda _: TICK),
    "firmware-law": law,
}


@pytest.mark.parametrize("name", SITUATIONS)
def test_the_screen_is_small_and_as_it_was(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(transport, "described_ports", lambda: [("serial:///dev/ttyACM0", "Teensy")])
    made = image.Image(*(tmp_path.joinpath(f"teensy41.{kind}") for kind in ("elf", "hex", "map")), 21_345, 16_789)
    monkeypatch.setattr(image, "build", lambda *_, **__: made)
    found = SITUATIONS[name]()
    check_screen(name, str(found))
    assert len(found.rows()) <= 6
    told = found.to_dict()
    assert told["schema"] == f"{name.replace('-', '.')}/1"
    assert [each["code"] for each in told["findings"]] == [each.code for each in found.findings]
