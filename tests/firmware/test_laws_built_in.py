"""An image has the laws that were chosen, says which, and refuses others in one line."""

from __future__ import annotations

import pytest

import frictionloop as fl
from frictionloop.device.errors import Refused
from frictionloop.firmware.built_in import KINDS, law_bits, law_names
from frictionloop.firmware.image import build
from frictionloop.quantities import FrictionloopError


def symbols(image) -> str:
    return image.map.read_text()


def test_by_default_all_are_built_in(images):
    for name in ("pi", "open_loop", "filtered_pi", "limit_observer"):
        assert f"fl_{name}_step" in symbols(images("pi"))


def test_laws_that_are_left_out_leave_their_room(images, law_words, tmp_path):
    small = build("teensy31", law_words["pi"].tolist(), tmp_path, laws=["pi"])
    assert "fl_filtered_pi_step" not in symbols(small)
    assert small.flash_bytes < images("pi").flash_bytes - 4000
    assert small.ram_bytes < images("pi").ram_bytes - 2000


def test_the_notch_pi_is_a_filtered_pi(law_words):
    assert law_names(law_bits(["notch_pi", "pi"], law_words["notch_pi"])) == ("pi", "filtered_pi")


def test_all_are_where_none_is_named(law_words):
    assert law_names(law_bits(None, law_words["pi"])) == KINDS


@pytest.mark.parametrize(
    ("laws", "says"),
    [
        (["pi", "pid"], r"^laws = 'pid': must be pi, lookup, filtered_pi, .*notch_pi$"),
        (["limit_observer", "lookup"], r"^laws = 'limit_observer, lookup': must be with pi, which runs$"),
        ([], r"^laws = '': must be with pi"),
    ],
)
def test_bad_choices_are_one_line(law_words, tmp_path, laws, says):
    with pytest.raises(FrictionloopError, match=says):
        build("teensy31", law_words["pi"].tolist(), tmp_path / "none", laws=laws)
    assert not (tmp_path / "none").exists()


def test_a_device_tells_its_laws_and_refuses_others(law_words, tmp_path):
    pytest.importorskip("unicorn", reason="install frictionloop[emulator]")
    some = build("teensy31", law_words["pi"].tolist(), tmp_path, laws=["pi", "lookup", "notch_pi"])
    with fl.connect(f"emulated:{some.elf}") as device:
        assert device.info.laws == ("pi", "lookup", "filtered_pi")
        device.set("law.number", 4)
        with pytest.raises(Refused) as refused:
            device.commit()
    assert str(refused.value) == (
        "commit: refused, law.number = 4: must be one of 1 pi, 2 lookup, 3 filtered_pi; "
        "firmware build --laws limit_observer"
    )


def test_the_library_of_this_machine_has_them_all():
    with fl.connect("sim:") as device:
        assert device.info.laws == KINDS
