"""Compare registers.h, the bits this board sets and the emulator's register model with the vendor's SVD file.

    python firmware/boards/teensy31/check_registers.py MK20D7.svd

prints what differs; exit code 1 if anything does. The file is not part of this project.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from c_source import BOARD, constants, evaluate, source
from svd import Svd

from frictionloop.device.emulator.registers import GATES, PIT0_INTERRUPT, REGISTERS, UART0_INTERRUPT
from frictionloop.quantities import FrictionloopError

NOT_IN_SVD = {"DEMCR", "DWT_CTRL", "DWT_CYCCNT"}
"""Of the core: ARMv7-M Architecture Reference Manual, C1."""
FIELDS = """
board.c      PIT_ON            PIT_TCTRL0  TEN=1
board.c      PIT_INTERRUPT     PIT_TCTRL0  TIE=1
board.c      PIT_EXPIRED       PIT_TFLG0   TIF=1
carrier.c    CLOCK_BUS         FTM0_SC     CLKS=1
carrier.c    EDGE_ALIGNED_HIGH FTM0_C0SC   MSB=1 ELSB=1
carrier.c    PIN_GPIO          PORTC_PCR1  MUX=1
carrier.c    PIN_CARRIER       PORTC_PCR1  MUX=4
clock.c      OSC_18PF          OSC_CR      SC8P=1 SC2P=1
clock.c      C1_EXTERNAL       MCG_C1      CLKS=2 FRDIV=4
clock.c      C1_PLL            MCG_C1      FRDIV=4
clock.c      C2_CRYSTAL        MCG_C2      RANGE0=2 EREFS0=1
clock.c      C5_BY_6           MCG_C5      PRDIV0=5
clock.c      C6_TIMES_27       MCG_C6      PLLS=1 VDIV0=3
clock.c      S_CRYSTAL         MCG_S       OSCINIT0=1
clock.c      S_INTERNAL        MCG_S       IREFST=1
clock.c      S_SOURCE          MCG_S       CLKST=3
clock.c      S_SOURCE_EXTERNAL MCG_S       CLKST=2
clock.c      S_SOURCE_PLL      MCG_S       CLKST=3
clock.c      S_PLL             MCG_S       PLLST=1
clock.c      S_LOCKED          MCG_S       LOCK0=1
clock.c      DIVIDERS          SIM_CLKDIV1 OUTDIV1=0 OUTDIV2=1 OUTDIV4=2
converters.c FORCE_ALONG       ADC0_SC1A   ADCH=8
converters.c FORCE_ACROSS      ADC1_SC1A   ADCH=9
converters.c LOAD              ADC0_SC1B   ADCH=12
converters.c POSITION          ADC1_SC1B   ADCH=0
converters.c CFG1_9_MHZ        ADC0_CFG1   MODE=3 ADICLK=1 ADIV=1
converters.c CFG1_CALIBRATION  ADC0_CFG1   MODE=3 ADICLK=1 ADIV=3
converters.c SC2_HARDWARE      ADC0_SC2    ADTRG=1
converters.c SC3_MEAN_OF_4     ADC0_SC3    AVGE=1 AVGS=0
converters.c SC3_MEAN_OF_32    ADC0_SC3    AVGE=1 AVGS=3
converters.c SC3_CALIBRATE     ADC0_SC3    CAL=1
converters.c SC3_FAILED        ADC0_SC3    CALF=1
converters.c PDB_LOAD          PDB_SC      LDOK=1
converters.c PDB_ENABLE        PDB_SC      PDBEN=1
converters.c PDB_TIMER_0       PDB_SC      TRGSEL=4
converters.c PDB_BOTH          PDB_CH0C1   EN=3 TOS=3 BB=2
port.c       QUEUES_ON         UART0_PFIFO TXFE=1 RXFE=1
port.c       QUEUES_EMPTY      UART0_CFIFO TXFLUSH=1 RXFLUSH=1
port.c       RECEIVER_EMPTY    UART0_CFIFO RXFLUSH=1
port.c       SEND_INTERRUPT    UART0_C2    TIE=1
port.c       RECEIVE_INTERRUPT UART0_C2    RIE=1
port.c       SEND              UART0_C2    TE=1
port.c       RECEIVE           UART0_C2    RE=1
port.c       OVERRUN           UART0_S1    OR=1
port.c       PIN_UART          PORTB_PCR16 MUX=3
port.c       PULL_UP           PORTB_PCR16 PE=1 PS=1
watchdog.c   POWER_ON          RCM_SRS0    POR=1
watchdog.c   PIN               RCM_SRS0    PIN=1
watchdog.c   BY_WATCHDOG       RCM_SRS0    WDOG=1
watchdog.c   LOW_VOLTAGE       RCM_SRS0    LVD=1
watchdog.c   SOFTWARE          RCM_SRS1    SW=1
startup.c    security          NV_FSEC     SEC=2 FSLACC=3 MEEN=1 KEYEN=3
startup.c    option            NV_FOPT     LPBOOT=1 EZPORT_DIS=0 NMI_DIS=0
watchdog.c   ENABLED           WDOG_STCTRLH WDOGEN=1
watchdog.c   IN_STOP           WDOG_STCTRLH STOPEN=1
watchdog.c   IN_WAIT           WDOG_STCTRLH WAITEN=1
"""
"""What each constant of the C is meant to say, in the vendor's names."""


def main() -> int:
    """Print the differences and return the exit code."""
    if len(sys.argv) != 2:
        print("usage: check_registers.py MK20D7.svd (one is in the source distribution of cmsis-svd==0.4 on PyPI: "
              "cmsis_svd/data/Freescale/MK20D7.svd)", file=sys.stderr)  # fmt: skip
        return 2
    svd = Svd(Path(sys.argv[1]))
    found = [*headers(svd), *model(svd), *bits(svd), *gates(svd), *interrupts(svd)]
    registers, named = len(REGISTERS) - len(NOT_IN_SVD), len(FIELDS.strip().splitlines())
    print("\n".join(found) or f"{registers} registers and {named} constants agree")
    return int(bool(found))


def headers(svd: Svd) -> list[str]:
    """Addresses and widths of registers.h."""
    text = source("registers.h")
    rows = [(name, int(address, 16), int(width) // 8)
            for name, width, address in re.findall(r"#define (\w+) REGISTER(\d+)\((0x\w+)\)", text)]  # fmt: skip
    members = re.findall(r"\b[A-Z]\w*", ",".join(re.findall(r"volatile uint32_t (.*?);", text)))
    for adc, base in re.findall(r"#define (ADC\d) \(\(converter \*\)(0x\w+)\)", text):
        rows += [(f"{adc}_{member}", int(base, 16) + 4 * place, 4) for place, member in enumerate(members)]
    for name, width, base in re.findall(r"#define (NVIC_\w+)\(\w+\) REGISTER(\d+)\((0x\w+)", text):
        rows.append((f"{name}0", int(base, 16), int(width) // 8))
    return [f"registers.h: {line}" for row in rows if row[0] not in NOT_IN_SVD for line in svd.compare(*row)]


def model(svd: Svd) -> list[str]:
    """Addresses, widths and reset values of the emulator."""
    rows = [row for row in REGISTERS if row.name not in NOT_IN_SVD]
    return [f"memory_map.py: {line}" for row in rows for line in svd.compare(*row)]


def bits(svd: Svd) -> list[str]:
    """Values of the constants that `FIELDS` names."""
    lines = []
    for row in FIELDS.split("\n")[1:-1]:
        file, constant, register, *fields = row.split()
        meant = svd.value(register, fields)
        value = constants(file).get(constant)
        if value != meant:
            lines.append(f"{file}: {constant} is {value}, {register} {' '.join(fields)} is {meant}")
    return lines


def gates(svd: Svd) -> list[str]:
    """Clock gates: the bits that the C sets, each named by its comment, and those of the emulator."""
    lines = []
    for path in sorted(BOARD.glob("*.c")):
        for register, value, names in re.findall(
            r"(SIM_SCGC\d) \|= ([^;]+);(?:\s*/\* (.*?) \*/)?", path.read_text(encoding="utf-8")
        ):
            fields = [f"{name.upper().replace(' ', '')}=1" for name in names.split(", ")]
            if evaluate(value, {}) != svd.value(register, fields):
                lines.append(f"{path.name}: {register} |= {value} does not mean {names or 'what a comment says'}")
    for block, (register, bit) in GATES.items():
        if svd.value(register, [f"{block}=1"]) != 1 << bit:
            lines.append(f"memory_map.py: the clock of {block} is not bit {bit} of {register}")
    return lines


def interrupts(svd: Svd) -> list[str]:
    """Numbers of the interrupts."""
    header = constants("registers.h")
    rows = [
        ("registers.h", header["UART0_INTERRUPT"], "UART0_RX_TX"), ("memory_map.py", UART0_INTERRUPT, "UART0_RX_TX"),
        ("registers.h", header["PIT0_INTERRUPT"], "PIT0"), ("memory_map.py", PIT0_INTERRUPT, "PIT0"),
    ]  # fmt: skip
    lines = [f"{file}: {name} is interrupt {svd.interrupts.get(name)}, not {number}"
             for file, number, name in rows if svd.interrupts.get(name) != number]  # fmt: skip
    if header["INTERRUPTS"] <= max(svd.interrupts.values(), default=0):
        lines.append(f"registers.h: there are more than {header['INTERRUPTS']} interrupts")
    return lines


if __name__ == "__main__":
    try:
        sys.exit(main())
    except FrictionloopError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
