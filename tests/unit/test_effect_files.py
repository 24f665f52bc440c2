"""Effects out of files and into files: pictures, sounds, envelopes, hjif, TOML, and what is refused."""

from __future__ import annotations

import json
import struct
import wave as wavefile
import zlib

import numpy as np
import pytest
from PIL import Image

import frictionloop as fl
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.force_channel import scaled

R = fl.rendering


def picture(path, grey, **more):
    Image.fromarray(grey).save(path, **more)
    return path


@pytest.mark.parametrize(("kind", "white"), [(np.uint8, 255), (np.uint16, 65535)])
@pytest.mark.parametrize("ending", ["png", "tiff"])
def test_a_picture_is_a_map_of_its_greys(tmp_path, kind, white, ending):
    grey = np.array([[0, white], [white // 2, 0], [white, white]], dtype=kind)
    path = picture(tmp_path / f"grey.{ending}", grey)
    made = R.read_image(path, mm_per_pixel=0.5, polarity="bright", low_n=0.2, high_n=0.6)
    assert np.allclose(made.map.table, 0.2 + 0.4 * grey[::-1] / white)
    assert (made.map.start_mm, made.map.start_y_mm, made.map.pitch_mm) == (-0.25, -0.5, 0.5)
    top_right = R.Touch(x_mm=0.25, y_mm=0.5)
    assert float(made.map.force_of(top_right)) == pytest.approx(0.6)
    dark = R.read_image(path, mm_per_pixel=0.5, polarity="dark", low_n=0.2, high_n=0.6)
    assert np.allclose(dark.map.table, 0.8 - made.map.table)


def tiff(path, grey, white_is_0=False, orientation=1):
    """Write a TIFF by its bytes, of which Pillow writes neither kind."""
    entries = [(256, 4, grey.shape[1]), (257, 4, grey.shape[0]), (258, 3, 8 * grey.itemsize), (259, 3, 1)]
    entries += [(262, 3, int(not white_is_0)), (273, 4, 8), (274, 3, orientation), (277, 3, 1), (278, 4, grey.shape[0])]
    entries.append((279, 4, grey.nbytes))
    packed = b"".join(struct.pack("<HHII", tag, kind, 1, value) for tag, kind, value in entries)
    content = b"II*\0" + struct.pack("<I", 8 + grey.nbytes) + grey.tobytes()
    path.write_bytes(content + struct.pack("<H", len(entries)) + packed + bytes(4))
    return path


GREYS = np.arange(0, 240, 20, dtype=np.uint8).reshape(3, 4)
TURNED = {1: GREYS, 2: GREYS[:, ::-1], 3: GREYS[::-1, ::-1], 4: GREYS[::-1], 6: np.rot90(GREYS, -1), 8: np.rot90(GREYS)}


@pytest.mark.parametrize("orientation", TURNED)
@pytest.mark.parametrize("ending", ["tiff", "png"])
def test_a_picture_is_turned_as_it_says_of_itself(tmp_path, orientation, ending):
    path = tmp_path / f"a.{ending}"
    if ending == "tiff":
        tiff(path, GREYS, orientation=orientation)
    else:
        image = Image.fromarray(GREYS)
        image.getexif()[274] = orientation
        image.save(path, exif=image.getexif())
    made = R.read_image(path, mm_per_pixel=1.0, polarity="bright", low_n=0.0, high_n=1.0)
    assert np.allclose(made.map.table[::-1], TURNED[orientation] / 255)
    assert made.pixels == TURNED[orientation].shape[::-1]


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_white_may_be_0(tmp_path, kind):
    grey = GREYS.astype(kind) * (np.iinfo(kind).max // 255)
    made = R.read_image(tiff(tmp_path / "a.tiff", grey, True), mm_per_pixel=1.0, polarity="dark", low_n=0.0, high_n=1.0)
    assert np.allclose(made.map.table[::-1], GREYS / 255)


def test_colours_are_greys_on_white_and_it_is_told(tmp_path):
    clear = np.zeros((3, 4, 4), np.uint8)
    clear[..., 3] = GREYS  # black, less and less transparent
    negative = Image.fromarray(GREYS).convert("P")
    negative.putpalette([255 - k for k in range(256) for _ in range(3)])
    negative.save(tmp_path / "palette.png")
    for path in (picture(tmp_path / "clear.png", clear), tmp_path / "palette.png"):
        found = R.import_effect(path, mm_per_pixel=1.0, polarity="dark", low_n=0.0, high_n=1.0)
        assert np.allclose(found.effect.table[::-1], GREYS / 255, atol=1 / 255)
        assert [(each.code, each.value) for each in found.findings] == [("EFFECT-LEFT", "colours, in grey")]


def test_a_sound_is_lifted_above_0_and_its_first_channel_is_said_to_be_taken(tmp_path):
    with wavefile.open(str(tmp_path / "a.wav"), "wb") as file:
        file.setparams((2, 2, 1000, 0, "NONE", "none"))
        file.writeframes(np.repeat(np.arange(-16384, 16384, 64, dtype="<i2"), 2).tobytes())
    found = R.import_effect(tmp_path / "a.wav", scale=0.2)
    assert [(each.code, each.value, each.more["path"]) for each in found.findings] == [
        ("TAKEN-FOR", "0", "column"),
        ("TAKEN-FOR", 0.45, "offset_n"),
    ]
    assert min(found.effect.values_n) == pytest.approx(0.35, abs=0.01)
    given = R.import_effect(tmp_path / "a.wav", scale=0.2, offset_n=0.0, column="1")
    assert given.findings == () and given.least_n == pytest.approx(-0.1, abs=0.01)


def test_a_large_picture_is_reduced_with_a_finding(tmp_path):
    grey = np.tile(np.arange(400, dtype=np.uint16) * 160, (300, 1))
    made = R.read_image(picture(tmp_path / "large.png", grey), mm_per_pixel=0.1, polarity="bright")
    assert made.reduced == 2
    assert (made.pixels, made.map.table.shape, made.map.pitch_mm) == ((400, 300), (150, 200), 0.2)
    found = R.import_effect(tmp_path / "large.png", mm_per_pixel=0.1, polarity="bright")
    assert [each.code for each in found.findings] == ["PICTURE-REDUCED"]
    full = 0.3 + 0.3 * grey[0].reshape(-1, 2).mean(axis=1) / 65535
    assert np.allclose(made.map.table[0], full)


@pytest.mark.slow
def test_a_picture_that_the_library_does_not_even_open_is_told_the_same(tmp_path):
    """50,000 pixels a side: a PNG of one bit has room for them in 300 kB."""
    rows = zlib.compress(bytes((50_000 // 8 + 1) * 50_000))
    pieces = (b"IHDR", struct.pack(">IIBBBBB", 50_000, 50_000, 1, 0, 0, 0, 0)), (b"IDAT", rows), (b"IEND", b"")
    crc = [zlib.crc32(name + content) for name, content in pieces]
    chunks = (
        struct.pack(">I", len(content)) + name + content + struct.pack(">I", check)
        for (name, content), check in zip(pieces, crc, strict=True)
    )
    (tmp_path / "huge.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunks))
    with pytest.raises(FrictionloopError, match=r"huge\.png: .*2,500,000,000 pixels.*100,000,000.*by 5"):
        R.read_image(tmp_path / "huge.png", mm_per_pixel=0.1, polarity="bright")


def test_what_a_map_is_between_and_beyond_its_values_goes_through_a_png(tmp_path):
    made = R.Map(values_n=(0.2, 0.6, 0.4), pitch_mm=1.0, between="nearest", beyond="repeat")
    R.write_image(made, tmp_path / "map.png")
    back = R.read_image(tmp_path / "map.png").map
    assert (back.between, back.beyond) == ("nearest", "repeat")


def test_a_map_goes_through_a_png_with_its_scale(tmp_path):
    made = R.rasterise(R.LIBRARY["braille"], 12.0, 8.0, 0.25)
    for polarity in ("bright", "dark"):
        R.write_image(made, tmp_path / "map.png", polarity)
        back = R.read_image(tmp_path / "map.png")
        assert np.abs(back.map.table - made.table).max() <= np.ptp(made.table) / 65535
        assert (back.map.pitch_mm, back.map.start_mm, back.map.start_y_mm) == (0.25, made.start_mm, made.start_y_mm)


def test_a_text_is_a_map_of_its_letters():
    made = R.text_map("I", height_mm=8.0, low_n=0.3, high_n=0.6)
    middle = made.table[made.table.shape[0] // 2]
    assert made.table.min() == pytest.approx(0.3)
    assert middle.max() > 0.55
    assert made.table[0].max() == pytest.approx(0.3)


def test_a_recording_is_played_by_place(tmp_path):
    rate, speed = 2000.0, 40.0
    time = np.arange(2000) / rate
    path = tmp_path / "texture.csv"
    path.write_text("force_n\n" + "\n".join(f"{v:.9f}" for v in 0.4 + 0.05 * np.sin(2 * np.pi * 20.0 * time)) + "\n")
    made = R.read_texture(fl.Recording(path=path, column="force_n", rate_hz=rate, scale=1.0), speed, pitch_mm=0.05)
    x = np.linspace(5.0, 30.0, 200)
    assert np.allclose(made.force_of(R.Touch(x_mm=x)), 0.4 + 0.05 * np.sin(2 * np.pi * x / 2.0), atol=1e-3)


def test_a_wave_goes_through_a_wav_with_its_scale(tmp_path):
    wave = R.Wave(values_n=tuple((0.1 + 0.2 * np.sin(np.arange(50))).tolist()), rate_hz=500.0)
    R.write_wave(wave, tmp_path / "wave.wav")
    with wavefile.open(str(tmp_path / "wave.wav")) as file:  # another reader
        assert (file.getframerate(), file.getnframes(), file.getsampwidth()) == (500, 50, 2)
    back = R.read_wave(fl.Recording(path=tmp_path / "wave.wav"), 500.0)
    assert np.abs(np.subtract(back.values_n, wave.values_n)).max() <= np.ptp(wave.values_n) / 65534
    assert scaled(fl.Recording(path=tmp_path / "wave.wav")).force.tolist() == list(back.values_n)


def test_a_texture_is_fitted_and_made_anew():
    truth = R.Resynthesis(coefficients=(1.2, -0.5), noise_n=0.02, offset_n=0.4, values=32768, pitch_mm=0.1)
    values = truth.force_of(R.Touch(x_mm=0.1 * np.arange(32768)))
    found = R.fit_texture(values, 0.1, order=2, seed=3)
    assert np.allclose(found.coefficients, (1.2, -0.5), atol=0.02)
    assert found.noise_n == pytest.approx(0.02, rel=0.02)
    again = R.fit_texture(values, 0.1, order=12).model_copy(update={"values": 32768, "seed": 5})
    made = again.force_of(R.Touch(x_mm=0.1 * np.arange(32768)))
    spectra = [np.abs(np.fft.rfft(each - each.mean())) ** 2 for each in (values, made)]
    bands = [np.array([part.mean() for part in np.array_split(each[1:], 20)]) for each in spectra]
    assert np.abs(10 * np.log10(bands[1] / bands[0])).max() < 1.5
    assert np.corrcoef(values, made)[0, 1] < 0.1


@pytest.mark.parametrize(
    "effect",
    [
        R.Constant(level_n=0.4),
        R.Grating(spacing_mm=4.0),
        R.Grating(spacing_mm=4.0, shape="triangle"),
        R.Grating(spacing_mm=3.0),
        R.Map(values_n=(0.2, 0.6, 0.4, 0.4), pitch_mm=10.0, start_mm=-15.0),
    ],
)
def test_an_effect_goes_through_hjif(tmp_path, effect):
    left = R.write_hjif(effect, tmp_path / "effect.hjif")
    back = R.read_hjif(tmp_path / "effect.hjif")
    x = R.Touch(x_mm=np.linspace(-14.0, 14.0, 300))
    assert np.abs(back.effect.force_of(x) - effect.force_of(x)).max() < 1e-3
    assert back.left == ()
    assert left == (() if effect.period_mm is None else ("no end: 100 mm of it",))
    tree = json.loads((tmp_path / "effect.hjif").read_text())
    needed = {"version", "profile", "level", "date", "description", "timescale", "perceptions", "avatars", "syncs"}
    assert needed <= tree.keys()


def hjif(tmp_path, *bands, modality="Friction", **more):
    channel = {"id": 0, "description": "", "gain": 0.5, "mixing_coefficient": 1.0, "body_part_mask": 0, "bands": bands}
    perception = {"id": 0, "perception_modality": modality, "channels": [channel], "effect_library": [], **more}
    path = tmp_path / "given.hjif"
    path.write_text(json.dumps({"perceptions": [perception]}))
    return path


def band(kind, frames, **more):
    effect = {"effect_type": "Basis", "position": 0, "phase": 0, "base_signal": "Sine", "keyframes": frames}
    return {"band_type": kind, "lower_frequency_limit": 0, "upper_frequency_limit": 500, "effects": [effect], **more}


def test_what_hjif_cannot_carry_over_is_listed(tmp_path):
    curve = band("Curve", [{"relative_position": p, "amplitude_modulation": 1.0} for p in (0, 10)], curve_type="Cubic")
    click = band("Transient", [{"relative_position": 5, "amplitude_modulation": 0.4}])
    found = R.read_hjif(hjif(tmp_path, curve, click, band("WaveletWave", [])))
    assert found.left == ("Cubic curve (read as linear)", "WaveletWave band")
    assert float(found.effect.force_of(R.Touch(x_mm=5.25))) == pytest.approx(0.5 + 0.2)
    assert float(found.effect.force_of(R.Touch(x_mm=2.0))) == pytest.approx(0.5)


def test_a_file_says_what_it_does_not_carry(tmp_path):
    bump = R.find("bump")
    assert R.write(bump, tmp_path / "bump.toml") == ()
    assert R.write(bump, tmp_path / "bump.png")[0].startswith("other touches than forth")
    assert R.write(R.find("braille"), tmp_path / "cell.hjif") == ("what is beyond the map; 60 mm of it",)
    looped = R.Wave(values_n=(0.1, 0.2, 0.1), rate_hz=500.0, loops=True)
    assert R.write(looped, tmp_path / "loop.wav") == ("that it loops",)


@pytest.mark.parametrize(
    ("more", "left"),
    [
        ({"base_signal": "SawToothUp"}, "SawToothUp signal"),
        ({"wavelet_bitstream": "ff"}, "effect.wavelet_bitstream"),
        ({"keyframes": []}, "Basis effect"),
    ],
)
def test_a_feature_that_is_not_known_is_listed_and_the_rest_is_read(tmp_path, more, left):
    frames = [{"relative_position": p, "amplitude_modulation": 1.0, "frequency_modulation": 100} for p in (10, 0)]
    wave, curve = band("VectorialWave", frames), band("Curve", frames)  # keyframes in any order
    wave["effects"][0] |= more
    found = R.read_hjif(hjif(tmp_path, curve, wave, priority=3))
    assert found.left == ("perception.priority", left)
    assert found.effect.force_of(R.Touch(x_mm=0.0)) == pytest.approx(0.5)


def test_envelopes_of_vibration_are_waves(tmp_path):
    points = [
        {"time": 0.0, "amplitude": 0.0},
        {"time": 0.1, "amplitude": 1.0, "emphasis": {}},
        {"time": 0.2, "amplitude": 0.5},
    ]
    tree = {"signals": {"continuous": {"envelopes": {"amplitude": points, "frequency": [{"time": 0, "frequency": 1}]}}}}
    (tmp_path / "a.haptic").write_text(json.dumps(tree))
    found = R.read_envelope(tmp_path / "a.haptic", full_n=0.2)
    assert np.allclose(found.wave.force_of(R.Touch(time_s=np.array([0.05, 0.1, 0.2]))), [0.1, 0.2, 0.1])
    assert found.left == ("frequency envelope", "emphasis")
    intensity = {"ParameterID": "HapticIntensity", "ParameterValue": 0.5}
    events = [
        {"Event": {"Time": 0.0, "EventType": "HapticContinuous", "EventDuration": 0.1, "EventParameters": [intensity]}},
        {"Event": {"Time": 0.2, "EventType": "HapticTransient", "EventParameters": []}},
        {"Event": {"Time": 0.2, "EventType": "AudioCustom"}},
    ]
    (tmp_path / "a.ahap").write_text(json.dumps({"Version": 1, "Pattern": events}))
    found = R.read_envelope(tmp_path / "a.ahap", full_n=0.2)
    assert np.allclose(found.wave.force_of(R.Touch(time_s=np.array([0.05, 0.15, 0.205]))), [0.1, 0.0, 0.2], atol=1e-6)
    assert found.left == ("AudioCustom",)


def test_a_relief_is_the_slope_of_a_picture():
    height = R.Map(values_n=(0.0, 0.0, 0.5, 0.5), pitch_mm=2.0)
    relief = R.Relief(height=height, load_n=0.5)
    assert float(relief.force_of(R.Touch(x_mm=3.0))) == pytest.approx(0.125)
    assert float(relief.force_of(R.Touch(x_mm=3.0, speed_mm_s=-1.0))) == pytest.approx(-0.125)
    player = R.Player(R.Constant(level_n=0.45) + relief)
    assert player.tick(3.0, 20.0, 0.5, 2e-4) == pytest.approx(0.575, abs=1e-6)


def grey(tmp_path):
    return picture(tmp_path / "grey.png", np.zeros((4, 4), np.uint8))


def test_a_wav_without_a_scale_is_refused(tmp_path):
    with wavefile.open(str(tmp_path / "a.wav"), "wb") as file:
        file.setparams((1, 2, 1000, 0, "NONE", "none"))
        file.writeframes(np.arange(100, dtype="<i2").tobytes())
    with pytest.raises(FrictionloopError, match="scale is missing: a number, in N"):
        R.read_wave(fl.Recording(path=tmp_path / "a.wav"), 1000.0)


def test_a_picture_of_50_000_pixels_a_side_is_told_how_to_be_reduced(tmp_path, monkeypatch):
    from frictionloop.rendering import images

    path = picture(tmp_path / "large.png", np.zeros((50, 50), np.uint8))
    monkeypatch.setattr(images, "MOST_PIXELS", 100)
    with pytest.raises(FrictionloopError, match=r"has 50 x 50 pixels: must be at most 100; reduce it by 5"):
        R.read_image(path, mm_per_pixel=1.0, polarity="dark")
