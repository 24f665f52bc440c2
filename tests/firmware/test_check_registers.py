"""The script that compares the Teensy's registers with an SVD file, on a small file made by hand."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "firmware/boards/teensy31/check_registers.py"
SVD = """<device><peripherals><peripheral><name>PIT</name><prependToName>PIT_</prependToName>
<baseAddress>0x40037000</baseAddress><interrupt><name>PIT0</name><value>68</value></interrupt><registers>
<register><name>MCR</name><addressOffset>0</addressOffset><size>32</size><resetValue>2</resetValue>
<resetMask>0xFFFFFFFF</resetMask></register>
<register><dim>2</dim><dimIncrement>0x10</dimIncrement><dimIndex>0,1</dimIndex><name>TCTRL%s</name>
<addressOffset>0x108</addressOffset><size>32</size><resetValue>0</resetValue><resetMask>0xFFFFFFFF</resetMask><fields>
<field><name>TEN</name><bitOffset>0</bitOffset><bitWidth>1</bitWidth></field>
<field><name>TIE</name><bitOffset>1</bitOffset><bitWidth>1</bitWidth></field></fields></register>
</registers></peripheral></peripherals></device>"""


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


def test_without_a_file_it_says_where_one_is():
    code, lines, error = check()
    assert (code, lines) == (2, [])
    assert "cmsis-svd==0.4" in error


def test_what_is_no_svd_file_is_one_line(tmp_path):
    code, lines, error = check(tmp_path / "missing.svd")
    assert (code, lines) == (2, [])
    assert "missing.svd: must be an SVD file" in error and error.count("\n") == 1
