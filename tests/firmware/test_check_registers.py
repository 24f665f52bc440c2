"""The script that compares the Teensy's registers with an SVD file: the vendor's, and a small one made by hand."""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from zipfile import ZipFile

import pytest

SCRIPT = Path(__file__).parents[2] / "firmware/boards/teensy41/check_registers.py"


def register(name, offset, fields, reset=0):
    """Return a register of 32 bits whose fields are name: (bit, width) or name: (bit, width, description)."""
    parts = "".join(
        f"<field><name>{field}</name><description>{(*place, '')[2]}</description><bitOffset>{place[0]}</bitOffset>"
        f"<bitWidth>{place[1]}</bitWidth></field>"
        for field, place in fields.items()
    )
    return (
        f"<register><name>{name}</name><addressOffset>{offset:#x}</addressOffset><size>32</size><resetValue>{reset:#x}"
        f"</resetValue><resetMask>0xFFFFFFFF</resetMask><fields>{parts}</fields></register>"
    )


def peripheral(name, base, content, interrupt=""):
    head = f"<name>{name}</name><prependToName>{name}_</prependToName><baseAddress>{base:#x}</baseAddress>"
    return f"<peripheral>{head}{interrupt}<registers>{content}</registers></peripheral>"


TIMERS = (
    "<cluster><dim>2</dim><dimIncrement>0x10</dimIncrement><name>TIMER[%s]</name><addressOffset>0x100</addressOffset>"
    + register("TCTRL", 8, {"TEN": (0, 1), "TIE": (1, 1)})
    + "</cluster>"
)
PIT = peripheral("PIT", 0x40084000, register("MCR", 0, {"MDIS": (1, 1)}, 2) + TIMERS,
                 "<interrupt><name>PIT</name><value>122</value></interrupt>")  # fmt: skip
CAUSES = {"ipp_reset_b": (0, 1), "lockup_sysresetreq": (1, 1), "ipp_user_reset_b": (3, 1), "wdog_rst_b": (4, 1),
          "wdog3_rst_b": (7, 1)}  # fmt: skip
SRC = peripheral("SRC", 0x400F8000, register("SRSR", 8, CAUSES, 1))
GATE = {"CG3": (6, 2, "lpspi4 clocks (lpspi4_clk_enable)"), "CG4": (8, 2, "adc2 clock (adc2_clk_enable)"),
        "CG6": (12, 2, "pit clocks (pit_clk_enable)"), "CG8": (16, 2, "adc1 clock"),
        "CG13": (26, 2, "gpio1 clock")}  # fmt: skip
CCM = peripheral("CCM", 0x400FC000, register("CCGR1", 0x6C, GATE, 0xFFFFFFFF))
TIE = "<name>TIE</name><description></description><bitOffset>1"
SVD = f"<device><peripherals>{PIT}{SRC}{CCM}</peripherals></device>"


def check(*arguments):
    run = subprocess.run([sys.executable, SCRIPT, *map(str, arguments)], capture_output=True, text=True, check=False)
    return run.returncode, run.stdout.splitlines(), run.stderr


@pytest.mark.slow
@pytest.mark.skipif(find_spec("pyocd") is None, reason="the vendor's file is in the wheel of pyocd")
def test_registers_and_constants_agree_with_the_vendors_file(tmp_path):
    with ZipFile(Path(find_spec("pyocd").origin).parent / "debug/svd/svd_data.zip") as files:
        name = next(name for name in files.namelist() if name.endswith("MIMXRT1062.xml"))
        code, lines, error = check(files.extract(name, tmp_path))
    assert (code, error) == (0, "") and lines[0].endswith("agree"), lines


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("", "", []),
        ("<addressOffset>0x100<", "<addressOffset>0x110<",
         ["registers.h: PIT_TCTRL0 is at 0x40084118, not 0x40084108",
          "registers.py: PIT_TCTRL0 is at 0x40084118, not 0x40084108"]),
        ("<resetValue>0x2<", "<resetValue>0x6<", ["registers.py: PIT_MCR is 0x6 after reset, not 0x2"]),
        (TIE, TIE[:-1] + "2",
         ["board.c: PIT_INTERRUPTS is 2, PIT_TCTRL0 TIE=1 is 4"]),
        ("<value>122", "<value>46", ["registers.h: PIT is interrupt 46, not 122",
                                     "registers.py: PIT is interrupt 46, not 122"]),
        ("<bitOffset>7<", "<bitOffset>5<",
         ["watchdog.c: BY_WATCHDOGS is 144, SRC_SRSR wdog_rst_b=1 wdog3_rst_b=1 is 48"]),
        ("<bitOffset>3<", "<bitOffset>2<", ["watchdog.c: PIN is 8, SRC_SRSR ipp_user_reset_b=1 is 4"]),
        ("0x400f8000", "0x400f9000", [f"{file}: SRC_SRSR is at 0x400f9008, not 0x400f8008"
                                      for file in ("registers.h", "registers.py")]),
        ("<bitOffset>12<", "<bitOffset>14<",
         ["clock.c: CCM_CCGR1 |= 3u << 12 does not mean PIT",
          "registers.py: the clock of PIT is not bits 12 and 13 of CCM_CCGR1"]),
        ("pit clocks", "pitt clocks",
         ["clock.c: CCM_CCGR1 |= 3u << 12 does not mean PIT",
          "registers.py: the clock of PIT is not bits 12 and 13 of CCM_CCGR1"]),
    ],
)  # fmt: skip
def test_what_differs_is_told(tmp_path, old, new, told):
    """All else is missing from the small file, and told too: the lines about what it has are these."""
    file = tmp_path / "small.svd"
    assert old in SVD
    file.write_text(SVD.replace(old, new) if old else SVD)
    code, lines, _ = check(file)
    assert code == 1
    about = ("PIT_MCR", "PIT_TCTRL0", "PIT is", "SRSR", "CCGR1")
    assert [line for line in lines if any(name in line for name in about)] == told
    assert "registers.h: PWM4_MCTRL is not in the SVD file" in lines


def test_without_a_file_it_says_where_one_is():
    code, lines, error = check()
    assert (code, lines) == (2, [])
    assert "pyocd==0.46.0" in error


def test_what_is_no_svd_file_is_one_line(tmp_path):
    code, lines, error = check(tmp_path / "missing.svd")
    assert (code, lines) == (2, [])
    assert "missing.svd: must be an SVD file" in error and error.count("\n") == 1
