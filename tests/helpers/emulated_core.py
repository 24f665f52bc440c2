"""The law of an image on an emulated Cortex-M7, called without a board: unicorn with UC_MODE_THUMB alone.

Its UC_MODE_MCLASS is a Cortex-M33, whatever model is set.
"""

import struct

import unicorn
from unicorn import arm_const as arm

from frictionloop.firmware.image_files import elf_file

RETURN, SCRATCH, PAGE = 0x30000000, 0x38000000, 0x10000


class EmulatedLaw:
    """Calls fl_own_step of an image with its own table."""

    def __init__(self, elf):
        self.cpu = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB)
        self.cpu.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M7)
        with elf.open("rb") as file:
            content = elf_file(file)
            names = content.get_section_by_name(".symtab").iter_symbols()
            self.symbols = {each.name: each["st_value"] & ~1 for each in names}
            parts = [(each["p_vaddr"], each["p_memsz"], each.data()) for each in content.iter_segments("PT_LOAD")]
        pages = {at // PAGE + k for at, size, _ in parts for k in range((at % PAGE + size) // PAGE + 1)}
        for page in {*pages, RETURN // PAGE, SCRATCH // PAGE}:
            self.cpu.mem_map(page * PAGE, PAGE)
        for at, _, data in parts:
            self.cpu.mem_write(at, data)
        self.cpu.reg_write(arm.UC_ARM_REG_FPEXC, 1 << 30)

    def step(self, state, measured, setpoint_n, low_n, high_n):
        """Run a tick; return the bytes of its state, of u and of saturated."""
        given = struct.pack(f"<{len(state) + 5}d", *state, *measured)
        self.cpu.mem_write(SCRATCH, given)
        seen = SCRATCH + 8 * len(state)
        for k, number in enumerate((SCRATCH, seen, self.symbols["fl_built_parameters"])):
            self.cpu.reg_write(arm.UC_ARM_REG_R0 + k, number)
        for k, (bits,) in enumerate(struct.iter_unpack("<Q", struct.pack("<3d", setpoint_n, low_n, high_n))):
            self.cpu.reg_write(arm.UC_ARM_REG_D0 + k, bits)
        self.cpu.reg_write(arm.UC_ARM_REG_SP, SCRATCH + PAGE - 64)
        self.cpu.reg_write(arm.UC_ARM_REG_LR, RETURN | 1)
        self.cpu.emu_start(self.symbols["fl_own_step"] | 1, RETURN, count=10**6)
        out = (self.cpu.reg_read(arm.UC_ARM_REG_D0 + k) for k in range(2))
        return bytes(self.cpu.mem_read(SCRATCH, 8 * len(state))) + struct.pack("<2Q", *out)
