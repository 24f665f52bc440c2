"""The script that compares the Teensy's registers with an SVD file, on a small file made by hand."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "firmware/boards/teensy41/check_registers.py"
SVD = """<device><peripherals><peripheral><name>PIT</name><prependToName>PIT_</prependToName>
<baseAddress>0x40037000</baseAddress><interrupt><name>PIT0</name><value>68</value></interrupt><registers>
<register><name>MCR</name><addressOffset>0</addressOffset><size>32</size><resetValue>2</resetValue>
<resetMask>0xFFFFFFFF</resetMask></register>
<register><dim>2</dim><dimIncrement>0x10</dimIncrement><dimIndex>0,1</dimIndex><name>TCTRL%s</name>
<addressOffset>0x108</addressOffset><size>32</size><resetValue>0</resetValue><resetMask>0xFFFFFFFF</resetMask><fields>
<field><name>TEN</name><bitOffset>0</bitOffset><bitWidth>1</bitWidth></field>
<field><name>TIE</name><bitOffset>1</bitOffset><bitWidth>1</bitWidth></field></fields></register>
</registers></peripheral></peripherals></device>"""

BITS = {"LVD": 1, "WDOG": 5, "PIN": 6, "POR": 7}
RESETS = (
    "<device><peripherals><peripheral><name>RCM</name><prependToName>RCM_</prependToName>"
    "<baseAddress>0x4007F000</baseAddress><registers><register><name>SRS0</name><addressOffset>0</addressOffset>"
    "<size>8</size><resetValue>0x82</resetValue><resetMask>0xFF</resetMask><fields>"
    + "".join(
        f"<field><name>{n}</name><bitOffset>{b}</bitOffset><bitWidth>1</bitWidth></field>" for n, b in BITS.items()
    )
    + "</fields></register><register><name>SRS1</name><addressOffset>1</addressOffset><size>8</size>"
    "<resetValue>0</resetValue><resetMask>0xFF</resetMask><fields><field><name>SW</name><bitOffset>2</bitOffset>"
    "<bitWidth>1</bitWidth></field></fields></register></registers></peripheral></peripherals></device>"
)


def check(*arguments):
    run = subprocess.run([sys.executable, SCRIPT, *map(str, arguments)], capture_output=True, text=True, check=False)
    return run.returncode, run.stdout.splitlines(), run.stderr


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("", "", []),
        ("0x108", "0x118", ["registers.h: PIT_TCTRL0 is at 0x40037118, not 0x40037108",
                            "memory_map.py: PIT_TCTRL0 is at 0x40037118, not 0x40037108"]),
        ("<size>32", "<size>16", ["registers.h: PIT_MCR has 2 bytes, not 4",
                                  "registers.h: PIT_TCTRL0 has 2 bytes, not 4",
                                  "memory_map.py: PIT_MCR has 2 bytes, not 4",
                                  "memory_map.py: PIT_TCTRL0 has 2 bytes, not 4"]),
        ("<resetValue>2", "<resetValue>6", ["memory_map.py: PIT_MCR is 0x6 after reset, not 0x2"]),
        ("<bitOffset>1", "<bitOffset>2", ["board.c: PIT_INTERRUPT is 2, PIT_TCTRL0 TIE=1 is 4"]),
        ("<value>68", "<value>46", ["registers.h: PIT0 is interrupt 46, not 68",
                                    "memory_map.py: PIT0 is interrupt 46, not 68"]),
    ],
)  # fmt: skip
def test_what_differs_is_told(tmp_path, old, new, told):
    """All else is missing from the small file, and told too: the lines about what it has are these."""
    file = tmp_path / "small.svd"
    file.write_text(SVD.replace(old, new) if old else SVD)
    code, lines, _ = check(file)
    assert code == 1
    about = ("PIT_MCR", "PIT_TCTRL0", "PIT0 is")
    assert [line for line in lines if any(name in line for name in about)] == told
    assert "registers.h: FTM0_MOD is not in the SVD file" in lines


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("", "", []),
        ("<bitOffset>5", "<bitOffset>4", ["watchdog.c: BY_WATCHDOG is 32, RCM_SRS0 WDOG=1 is 16"]),
        ("<bitOffset>1<", "<bitOffset>0<", ["watchdog.c: LOW_VOLTAGE is 2, RCM_SRS0 LVD=1 is 1"]),
        ("<bitOffset>2", "<bitOffset>3", ["watchdog.c: SOFTWARE is 4, RCM_SRS1 SW=1 is 8"]),
        ("0x4007F000", "0x4007E000", [f"{file}: RCM_SRS{k} is at 0x4007e00{k}, not 0x4007f00{k}"
                                      for file in ("registers.h", "memory_map.py") for k in (0, 1)]),
        ("0x82", "0x80", ["memory_map.py: RCM_SRS0 is 0x80 after reset, not 0x82"]),
    ],
)  # fmt: skip
def test_what_tells_the_cause_of_a_reset_is_compared(tmp_path, old, new, told):
    file = tmp_path / "small.svd"
    file.write_text(RESETS.replace(old, new) if old else RESETS)
    _, lines, _ = check(file)
    assert [line for line in lines if "RCM_" in line] == told


def test_without_a_file_it_says_where_one_is():
    code, lines, error = check()
    assert (code, lines) == (2, [])
    assert "cmsis-svd==0.4" in error


def test_what_is_no_svd_file_is_one_line(tmp_path):
    code, lines, error = check(tmp_path / "missing.svd")
    assert (code, lines) == (2, [])
    assert "missing.svd: must be an SVD file" in error and error.count("\n") == 1
