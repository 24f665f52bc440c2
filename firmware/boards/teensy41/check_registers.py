"""Compare registers.h, the bits this board sets and the emulator's register model with the vendor's SVD file.

    python firmware/boards/teensy41/check_registers.py MIMXRT1062.xml

prints what differs; exit code 1 if anything does. The file is not part of this project.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from c_source import BOARD, constants, evaluate, source
from svd import Svd

from frictionloop.device.emulator.registers import GATES, LPUART6_INTERRUPT, PIT_INTERRUPT, REGISTERS
from frictionloop.quantities import FrictionloopError

NOT_IN_SVD = {"MPU_CTRL", "MPU_RBAR", "MPU_RASR", "DEMCR", "DWT_CTRL", "DWT_CYCCNT"}
"""Of the core: ARMv7-M Architecture Reference Manual, B3.5 and C1."""
FIELDS = """
board.c      PIT_ON              PIT_TCTRL0    TEN=1
board.c      PIT_INTERRUPTS      PIT_TCTRL0    TIE=1
board.c      PIT_EXPIRED         PIT_TFLG0     TIF=1
carrier.c    INDEPENDENT         PWM4_SM0CTRL2 INDEP=1
carrier.c    IN_WAIT             PWM4_SM0CTRL2 WAITEN=1
carrier.c    RELOAD_EVERY_PERIOD PWM4_SM0CTRL  FULL=1
carrier.c    FAULTS_HIGH         PWM4_FCTRL0   FLVL=15
carrier.c    FAULT_FLAGS         PWM4_FSTS0    FFLAG=15
carrier.c    CLEAR_LOAD          PWM4_MCTRL    CLDOK=1
carrier.c    LOAD                PWM4_MCTRL    LDOK=1
carrier.c    RUN                 PWM4_MCTRL    RUN=1
carrier.c    OUTPUT_A            PWM4_OUTEN    PWMA_EN=1
carrier.c    PIN_CARRIER         IOMUXC_MUX_AD_B1_08 MUX_MODE=1
carrier.c    PIN_GPIO            IOMUXC_MUX_AD_B1_08 MUX_MODE=5
clock.c      BUS_BY_3            CCM_CBCDR     IPG_PODF=2
clock.c      BUS_DIVIDER         CCM_CBCDR     IPG_PODF=3
clock.c      TIMER_FROM_CRYSTAL  CCM_CSCMR1    PERCLK_CLK_SEL=1
clock.c      TIMER_DIVIDER       CCM_CSCMR1    PERCLK_PODF=63
clock.c      PORT_FROM_CRYSTAL   CCM_CSCDR1    UART_CLK_SEL=1
clock.c      PORT_DIVIDER        CCM_CSCDR1    UART_CLK_PODF=63
clock.c      LOW_POWER           CCM_CLPCR     LPM=3
clock.c      TIMER_ON            PIT_TCTRL0    TEN=1
converters.c CFG_12_BIT          ADC1_CFG      MODE=2
converters.c CFG_BUS_BY_2_BY_4   ADC1_CFG      ADICLK=1 ADIV=2
converters.c CFG_8_CLOCKS        ADC1_CFG      ADSTS=3
converters.c CFG_FAST            ADC1_CFG      ADHSC=1
converters.c CFG_MEAN_OF_8       ADC1_CFG      AVGS=1
converters.c CFG_MEAN_OF_32      ADC1_CFG      AVGS=3
converters.c CFG_HARDWARE        ADC1_CFG      ADTRG=1
converters.c CFG_OVERWRITE       ADC1_CFG      OVWREN=1
converters.c GC_MEAN             ADC1_GC       AVGE=1
converters.c GC_CALIBRATE        ADC1_GC       CAL=1
converters.c GS_FAILED           ADC1_GS       CALF=1
converters.c HC_BY_ETC           ADC2_HC0      ADCH=16
converters.c ETC_TRIGGERS        ADC_ETC_CTRL  TRIG_ENABLE=17
converters.c ETC_BY_4            ADC_ETC_CTRL  PRE_DIVIDER=3
converters.c CHAIN_OF_2          ADC_ETC_TRIG0_CTRL TRIG_CHAIN=1
converters.c FIRST_BY_HC0        ADC_ETC_TRIG0_CHAIN_1_0 HWTS0=1 B2B0=1
converters.c SECOND_BY_HC1       ADC_ETC_TRIG4_CHAIN_1_0 HWTS1=2 B2B1=1
converters.c FROM_PIT0           XBARA1_SEL51  SEL103=56
converters.c FROM_PIT0           XBARA1_SEL53  SEL107=56
ads8688.c    CLOCK_BY_8          CCM_CBCMR     LPSPI_PODF=7
ads8688.c    FROM_PLL2           CCM_CBCMR     LPSPI_CLK_SEL=2
ads8688.c    CLOCK_SOURCE        CCM_CBCMR     LPSPI_CLK_SEL=3
ads8688.c    SCK_BY_4            LPSPI4_CCR    SCKDIV=2
ads8688.c    BETWEEN             LPSPI4_CCR    DBT=2
ads8688.c    BEFORE              LPSPI4_CCR    PCSSCK=2
ads8688.c    AFTER               LPSPI4_CCR    SCKPCS=2
ads8688.c    ENABLE              LPSPI4_CR     MEN=1
ads8688.c    RESET               LPSPI4_CR     RST=1 RTF=1 RRF=1
ads8688.c    MASTER              LPSPI4_CFGR1  MASTER=1
ads8688.c    FRAME_32            LPSPI4_TCR    FRAMESZ=31
ads8688.c    LATCH_ON_FALL       LPSPI4_TCR    CPHA=1
ads8688.c    RECEIVED            LPSPI4_SR     RDF=1
ads8688.c    PIN_SPI             IOMUXC_MUX_B0_00 MUX_MODE=3
port.c       BAUD_BY_12          LPUART6_BAUD  OSR=11
port.c       BAUD_BY_1           LPUART6_BAUD  SBR=1
port.c       QUEUES_ON           LPUART6_FIFO  TXFE=1 RXFE=1
port.c       QUEUES_EMPTY        LPUART6_FIFO  TXFLUSH=1 RXFLUSH=1
port.c       SEND_AT_1           LPUART6_WATER TXWATER=1
port.c       RECEIVE_ABOVE_1     LPUART6_WATER RXWATER=1
port.c       SEND_INTERRUPT      LPUART6_CTRL  TIE=1
port.c       RECEIVE_INTERRUPT   LPUART6_CTRL  RIE=1
port.c       SEND                LPUART6_CTRL  TE=1
port.c       RECEIVE             LPUART6_CTRL  RE=1
port.c       OVERRUN             LPUART6_STAT  OR=1
port.c       PIN_UART            IOMUXC_MUX_AD_B0_03 MUX_MODE=2
port.c       PULL_UP_22K         IOMUXC_PAD_AD_B0_03 PKE=1 PUE=1 PUS=3
port.c       HYSTERESIS          IOMUXC_PAD_AD_B0_03 HYS=1
port.c       FROM_PIN_0          IOMUXC_LPUART6_RX_SELECT_INPUT DAISY=1
protection.c CACHE               SCB_CCR       IC=1
protection.c FAULTS              SCB_SHCSR     MEMFAULTENA=1
startup.c    COPROCESSORS_10_11  SCB_CPACR     CP10=3 CP11=3
watchdog.c   ENABLED             RTWDOG_CS     EN=1
watchdog.c   IN_STOP             RTWDOG_CS     STOP=1
watchdog.c   IN_WAIT             RTWDOG_CS     WAIT=1
watchdog.c   OSCILLATOR          RTWDOG_CS     CLK=1
watchdog.c   COMMANDS_32         RTWDOG_CS     CMD32EN=1
watchdog.c   UNLOCKED            RTWDOG_CS     ULK=1
watchdog.c   TAKEN               RTWDOG_CS     RCS=1
watchdog.c   RESETS              SRC_SCR       mask_wdog3_rst=10
watchdog.c   MASK                SRC_SCR       mask_wdog3_rst=15
watchdog.c   POWER_ON            SRC_SRSR      ipp_reset_b=1
watchdog.c   SOFTWARE            SRC_SRSR      lockup_sysresetreq=1
watchdog.c   PIN                 SRC_SRSR      ipp_user_reset_b=1
watchdog.c   BY_WATCHDOGS        SRC_SRSR      wdog_rst_b=1 wdog3_rst_b=1
"""
"""What each constant of the C is meant to say, in the vendor's names."""


def main() -> int:
    """Print the differences and return the exit code."""
    if len(sys.argv) != 2:
        print("usage: check_registers.py MIMXRT1062.xml (one is in the wheel of pyocd==0.46.0 on PyPI: "
              "pyocd/debug/svd/svd_data.zip)", file=sys.stderr)  # fmt: skip
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
    for members, kind in re.findall(r"typedef struct \{(.*?)\} (\w+);", text, re.DOTALL):
        names = re.findall(r"\b[A-Z]\w*", members)
        for block, base in re.findall(rf"#define (\w+) \(\({kind} \*\)(0x\w+)\)", text):
            rows += [(f"{block}_{name}", int(base, 16) + 4 * place, 4) for place, name in enumerate(names)]
    for name, width, base in re.findall(r"#define (NVIC_\w+)\(\w+\) REGISTER(\d+)\((0x\w+)", text):
        rows.append((f"{name}0", int(base, 16), int(width) // 8))
    return [f"registers.h: {line}" for row in rows if row[0] not in NOT_IN_SVD for line in svd.compare(*row)]


def model(svd: Svd) -> list[str]:
    """Addresses, widths and reset values of the emulator."""
    rows = [row for row in REGISTERS if row.name not in NOT_IN_SVD]
    return [f"registers.py: {line}" for row in rows for line in svd.compare(*row)]


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
            r"(CCM_CCGR\d) \|= ([^;]+);(?:\s*/\* (.*?) \*/)?", path.read_text(encoding="utf-8")
        ):
            found = {number for name in names.split(", ") for number in gate(svd, register, name)}
            if evaluate(value, {}) != sum(found) or not found:
                lines.append(f"{path.name}: {register} |= {value} does not mean {names or 'what a comment says'}")
    for block, (register, bit) in GATES.items():
        if gate(svd, register, block) != [3 << bit]:
            lines.append(f"registers.py: the clock of {block} is not bits {bit} and {bit + 1} of {register}")
    return lines


OTHER_NAMES = {"RTWDOG": "WDOG3", "XBARA1": "XBAR1"}


def gate(svd: Svd, register: str, block: str) -> list[int]:
    """Return the bits whose field says in words that it is a block's clock."""
    name = OTHER_NAMES.get(block, block).lower()
    return [3 << place for place, words in svd.fields(register) if re.match(rf"{name} clocks?\b", words.lower())]


def interrupts(svd: Svd) -> list[str]:
    """Numbers of the interrupts."""
    header = constants("registers.h")
    rows = [
        ("registers.h", header["LPUART6_INTERRUPT"], "LPUART6"), ("registers.py", LPUART6_INTERRUPT, "LPUART6"),
        ("registers.h", header["PIT_INTERRUPT"], "PIT"), ("registers.py", PIT_INTERRUPT, "PIT"),
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
