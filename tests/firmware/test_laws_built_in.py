"""An image has the laws that were chosen, says which, and refuses others in one line."""

from __future__ import annotations

import pytest

import frictionloop as fl
from frictionloop.device.errors import Refused
from frictionloop.firmware.built_in import KINDS, RECOMMENDED, law_bits, law_names
from frictionloop.firmware.image import build
from frictionloop.quantities import FrictionloopError


def symbols(image) -> str:
    return image.map.read_text()


def test_by_default_the_tracker_is_left_out(images):
    assert "fl_filtered_pi_step" in symbols(images("pi"))
    assert "fl_tracker_step" not in symbols(images("pi"))
    assert "fl_schedule" not in symbols(images("pi"))
    assert "fl_tracker_step" in symbols(images("tracker"))


def test_laws_that_are_left_out_leave_their_room(images, law_words, tmp_path):
    small = build("teensy31", law_words["pi"].tolist(), tmp_path, laws=["pi"])
    assert "fl_filtered_pi_step" not in symbols(small)
    assert small.flash_bytes < images("pi").flash_bytes - 4000
    assert small.ram_bytes < images("pi").ram_bytes - 2000


def test_the_notch_pi_is_a_filtered_pi(law_words):
    assert law_names(law_bits(["notch_pi", "pi"], law_words["notch_pi"])) == ("pi", "filtered_pi")


def test_the_tables_law_is_built_in_where_none_is_named(law_words):
    assert law_names(law_bits(None, law_words["pi"])) == RECOMMENDED
    assert law_names(law_bits(None, law_words["tracker"])) == KINDS


@pytest.mark.parametrize(
    ("laws", "says"),
    [
        (["pi", "pid"], r"^laws = 'pid': the firmware has pi, lookup, filtered_pi, .*notch_pi$"),
        (["observer", "lookup"], r"^laws = observer, lookup: the image is to run pi, which must be among them$"),
        ([], r"^laws = : the image is to run pi"),
    ],
)
def test_bad_choices_are_one_line(law_words, tmp_path, laws, says):
    with pytest.raises(FrictionloopError, match=says):
        build("teensy31", law_words["pi"].tolist(), tmp_path / "none", laws=laws)
    assert not (tmp_path / "none").exists()


def test_a_device_tells_its_laws_and_refuses_others(images):
    pytest.importorskip("unicorn", reason="install frictionloop[emulator]")
    with fl.connect(f"emulated:{images('pi').elf}") as device:
        assert device.info.laws == RECOMMENDED
        device.set("law.number", 6)
        with pytest.raises(Refused) as refused:
            device.commit()
    assert str(refused.value) == (
        "commit: the device refuses law.number = 6, out of range; must be a law of its image: 1 pi, 2 lookup, "
        "3 filtered_pi, 4 observer, 5 super_twisting (firmware build --laws tracker builds tracker in)"
    )


def test_the_library_of_this_machine_has_them_all():
    with fl.connect("sim:") as device:
        assert device.info.laws == KINDS
