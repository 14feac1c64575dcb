#!/usr/bin/env python3
"""make_a2l.py ELF PARAMETERS A2L: the A2L file (ASAP2 1.6) of an ECU with sway_xcp.

ELF is a program built with -g: addresses, types and enumerations are read from it. PARAMETERS is
what `make_block --list` prints: the range of each word of the parameters. Measured is the status of
the core and the ECU's own counters; calibrated are all parameters. Units are in the names of the
core's fields; here each becomes its SI unit by a conversion.
"""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

from elftools.dwarf.die import DIE
from elftools.elf.elffile import ELFFile

UNITS = (
    # ending, SI unit, units of the field in one of it
    ("_mm_s", "m/s", 1000), ("_urad_s", "rad/s", 1000000), ("_ppm_per_s", "1/s", 1000000),
    ("_n_per_rad", "N/rad", 1), ("_milli_per_rad", "1/rad", 1000),
    ("_micro_per_s", "1/s", 1000000), ("_gm2", "kg m2", 1000), ("_urad", "rad", 1000000),
    ("_uhz", "Hz", 1000000), ("_ppm", "", 1000000), ("_mn", "N", 1000), ("_um", "m", 1000000),
    ("_us", "s", 1000000), ("_ms", "s", 1000), ("_g", "kg", 1000), ("_milli", "", 1000),
)  # fmt: skip
"""Longer endings stand before their own ends."""

ENUMERATED = {
    "alarm": "sway_alarm_state_t",
    "belief": "sway_belief_t",
    "source": "sway_source_t",
    "v_crit_kind": "sway_vcrit_t",
    "state": "sway_ecu_state_t",
}
"""Fields of the status and the ECU that hold one value of an enumeration."""

MEASURED = ("node.core.status", "node.accepted", "node.frame_fault")
ECU_FIELDS = ("state", "cause", "frames_received", "frames_sent", "requests_refused")
TYPES = {
    (1, False): "UBYTE",
    (2, False): "UWORD",
    (4, False): "ULONG",
    (8, False): "A_UINT64",
    (1, True): "SBYTE",
    (2, True): "SWORD",
    (4, True): "SLONG",
    (8, True): "A_INT64",
}
LIMITS = {
    4: (-2147483648, 2147483647),
    1: (-128, 127),
    2: (-32768, 32767),
    8: (-(2**63), 2**63 - 1),
}


@dataclass(frozen=True)
class Value:
    """One integer in the memory of the ECU."""

    name: str
    """As in C, from the structure on."""
    offset: int
    size: int
    signed: bool


def text(die: DIE, attribute: str) -> str:
    """An attribute's text, empty where there is none."""
    found = die.attributes.get(attribute)
    return found.value.decode() if found else ""


def number(die: DIE, attribute: str) -> int:
    """An attribute's number, 0 where there is none."""
    found = die.attributes.get(attribute)
    return int(found.value) if found else 0


@dataclass
class Program:
    """What is needed of an ELF file."""

    path: Path
    big_endian: bool = False
    structures: dict[str, DIE] = field(default_factory=dict)
    enumerations: dict[str, DIE] = field(default_factory=dict)
    symbols: dict[str, tuple[int, int]] = field(default_factory=dict)
    """Address and size of each object."""
    variables: dict[str, str] = field(default_factory=dict)
    """Name of the variable of each named type (the last one seen)."""

    def read(self) -> Program:
        """From `path`."""
        elf = ELFFile(self.path.open("rb"))
        if not elf.has_dwarf_info():
            sys.exit(f"{self.path}: no debug information; build it with -g")
        self.big_endian = not elf.little_endian
        for symbol in elf.get_section_by_name(".symtab").iter_symbols():
            if symbol["st_info"]["type"] == "STT_OBJECT":
                self.symbols[symbol.name] = (symbol["st_value"], symbol["st_size"])
        for unit in elf.get_dwarf_info().iter_CUs():
            for die in unit.get_top_DIE().iter_children():
                self._note(die)
        return self

    def _note(self, die: DIE) -> None:
        name = text(die, "DW_AT_name")
        if die.tag == "DW_TAG_typedef" and "DW_AT_type" in die.attributes:
            target = die.get_DIE_from_attribute("DW_AT_type")
            if target.tag == "DW_TAG_structure_type" and number(target, "DW_AT_byte_size"):
                self.structures[name] = target
            elif target.tag == "DW_TAG_enumeration_type":
                self.enumerations[name] = target
        elif die.tag == "DW_TAG_variable" and name in self.symbols:
            kind = (
                die.get_DIE_from_attribute("DW_AT_type") if "DW_AT_type" in die.attributes else die
            )
            self.variables[text(kind, "DW_AT_name")] = name

    def address_of(self, kind: str) -> int:
        """Address of the one variable of a type."""
        if kind not in self.variables:
            sys.exit(f"{self.path}: no variable of type {kind}: this program has no sway_xcp")
        return self.symbols[self.variables[kind]][0]

    def values(self, kind: str) -> list[Value]:
        """All integers in a structure."""
        if kind not in self.structures:
            sys.exit(f"{self.path}: type {kind} is not in its debug information")
        return list(_flatten(self.structures[kind], "", 0))

    def offset_of(self, kind: str, member: str) -> int:
        """Where a member begins."""
        for die in self.structures[kind].iter_children():
            if text(die, "DW_AT_name") == member:
                return number(die, "DW_AT_data_member_location")
        sys.exit(f"{self.path}: {kind} has no {member}")


def _bare(die: DIE) -> DIE:
    """A type without typedef, const, volatile."""
    while die.tag in ("DW_TAG_typedef", "DW_TAG_const_type", "DW_TAG_volatile_type"):
        die = die.get_DIE_from_attribute("DW_AT_type")
    return die


def _flatten(die: DIE, name: str, offset: int) -> list[Value]:
    """The integers of a type; pointers and unions are no values."""
    die = _bare(die)
    size = number(die, "DW_AT_byte_size")
    if die.tag == "DW_TAG_base_type":
        return [Value(name, offset, size, number(die, "DW_AT_encoding") in (5, 6))]
    if die.tag == "DW_TAG_enumeration_type":
        return [Value(name, offset, size, False)]
    found: list[Value] = []
    if die.tag == "DW_TAG_structure_type":
        for member in die.iter_children():
            inner = member.get_DIE_from_attribute("DW_AT_type")
            path = f"{name}.{text(member, 'DW_AT_name')}".lstrip(".")
            found += _flatten(inner, path, offset + number(member, "DW_AT_data_member_location"))
    elif die.tag == "DW_TAG_array_type":
        element = die.get_DIE_from_attribute("DW_AT_type")
        width = number(_bare(element), "DW_AT_byte_size")
        count = next((number(c, "DW_AT_upper_bound") + 1 for c in die.iter_children()), 0)
        for i in range(count if width else 0):
            found += _flatten(element, f"{name}[{i}]", offset + i * width)
    return found


def unit_of(name: str) -> tuple[str, str, int]:
    """Name of the conversion, SI unit and factor of a field, by its ending."""
    last = re.sub(r"\[\d+\]", "", name.rsplit(".", maxsplit=1)[-1])
    for ending, unit, factor in UNITS:
        if last.endswith(ending):
            return f"si{ending}", unit, factor
    return "NO_COMPU_METHOD", "", 1


def _conversion(name: str) -> str:
    last = name.rsplit(".", maxsplit=1)[-1]
    return ENUMERATED.get(last, unit_of(name)[0])


def _limits(value: Value, low: int, high: int) -> str:
    factor = unit_of(value.name)[2]
    return f"{low / factor:.12g} {high / factor:.12g}"


def _natural_limits(value: Value) -> tuple[int, int]:
    low, high = LIMITS[value.size]
    return (low, high) if value.signed else (0, high - low)


def measurement(value: Value, address: int) -> str:
    """One MEASUREMENT."""
    kind = TYPES[value.size, value.signed]
    limits = _limits(value, *_natural_limits(value))
    return (
        f'    /begin MEASUREMENT {value.name} "" {kind} {_conversion(value.name)} 0 0 {limits}\n'
        f"      ECU_ADDRESS 0x{address + value.offset:08X}\n"
        "    /end MEASUREMENT\n"
    )


def characteristic(value: Value, address: int, row: list[str]) -> str:
    """One CHARACTERISTIC; `row` is its line of `make_block --list`."""
    low, high = int(row[3]), int(row[4])
    comment = f"vehicle.toml: {row[1]}" if row[1].startswith(("car.", "trailer.")) else row[1]
    extended = ""
    if row[5:]:  # 0 (unknown) besides: the wider limits; the ECU knows the gap
        comment += ", or 0: unknown"
        extended = f"      EXTENDED_LIMITS {_limits(value, min(0, low), high)}\n"
    return (
        f'    /begin CHARACTERISTIC {value.name} "{comment}" VALUE '
        f"0x{address + value.offset:08X} word 0 {_conversion(value.name)} "
        f"{_limits(value, low, high)}\n{extended}    /end CHARACTERISTIC\n"
    )


def conversions(names: list[str], program: Program) -> str:
    """COMPU_METHODs of the fields there are."""
    out = ""
    used = {unit_of(n) for n in names}
    for name, unit, factor in sorted(u for u in used if u[0] != "NO_COMPU_METHOD"):
        out += (
            f'    /begin COMPU_METHOD {name} "" RAT_FUNC "%12.6" "{unit}"\n'
            f"      COEFFS 0 {factor} 0 0 0 1\n    /end COMPU_METHOD\n"
        )
    wanted = sorted({ENUMERATED[n.rsplit(".", 1)[-1]] for n in names
                     if n.rsplit(".", 1)[-1] in ENUMERATED})  # fmt: skip
    for name in wanted:
        if name not in program.enumerations:
            sys.exit(f"{program.path}: enumeration {name} is not in its debug information")
        rows = [(number(c, "DW_AT_const_value"), text(c, "DW_AT_name"))
                for c in program.enumerations[name].iter_children()]  # fmt: skip
        rows = [r for r in rows if not r[1].endswith("_COUNT")]
        out += (
            f'    /begin COMPU_METHOD {name} "" TAB_VERB "%3.0" ""\n'
            f"      COMPU_TAB_REF {name}_values\n    /end COMPU_METHOD\n"
            f'    /begin COMPU_VTAB {name}_values "" TAB_VERB {len(rows)}\n'
            + "".join(f'      {v} "{n}"\n' for v, n in rows)
            + "    /end COMPU_VTAB\n"
        )
    return out


INTERFACE = """    /begin IF_DATA XCP
      /begin PROTOCOL_LAYER 0x0101 1000 200 0 0 0 0 0 8 8 BYTE_ORDER_{order}
        ADDRESS_GRANULARITY_BYTE
{commands}        SEED_AND_KEY_EXTERNAL_FUNCTION "swaywatch_key"
      /end PROTOCOL_LAYER
      /begin PAG 1 /end PAG
      /begin DAQ DYNAMIC {lists} 3 0 OPTIMISATION_TYPE_DEFAULT ADDRESS_EXTENSION_FREE
        IDENTIFICATION_FIELD_TYPE_ABSOLUTE GRANULARITY_ODT_ENTRY_SIZE_DAQ_BYTE 7
        OVERLOAD_INDICATION_EVENT PRESCALER_SUPPORTED
        /begin TIMESTAMP_SUPPORTED 1 SIZE_DWORD UNIT_1US /end TIMESTAMP_SUPPORTED
        /begin EVENT "new estimate" "estimate" 0 DAQ {lists} 0 6 0 /end EVENT
        /begin EVENT "10 ms" "10 ms" 1 DAQ {lists} 10 6 0 /end EVENT
        /begin EVENT "100 ms" "100 ms" 2 DAQ {lists} 100 6 0 /end EVENT
      /end DAQ
      /begin XCP_ON_CAN 0x0100 CAN_ID_MASTER 0x6E4 CAN_ID_SLAVE 0x6E5 BAUDRATE 500000
        SAMPLE_POINT 87 SAMPLE_RATE SINGLE
      /end XCP_ON_CAN
    /end IF_DATA
"""
COMMANDS = """
GET_ID GET_SEED UNLOCK SET_MTA UPLOAD SHORT_UPLOAD BUILD_CHECKSUM DOWNLOAD SET_CAL_PAGE GET_CAL_PAGE
GET_PAG_PROCESSOR_INFO GET_SEGMENT_INFO GET_PAGE_INFO COPY_CAL_PAGE CLEAR_DAQ_LIST SET_DAQ_PTR
WRITE_DAQ SET_DAQ_LIST_MODE GET_DAQ_LIST_MODE START_STOP_DAQ_LIST START_STOP_SYNCH GET_DAQ_CLOCK
GET_DAQ_PROCESSOR_INFO GET_DAQ_RESOLUTION_INFO GET_DAQ_EVENT_INFO FREE_DAQ ALLOC_DAQ ALLOC_ODT
ALLOC_ODT_ENTRY
"""

SEGMENT = """    /begin MOD_PAR ""
      /begin MEMORY_SEGMENT parameters "parameters of the ECU" DATA RAM INTERN
        0x{address:08X} 0x{size:X} -1 -1 -1 -1 -1
        /begin IF_DATA XCP
          /begin SEGMENT 0 2 0 0 0
            /begin CHECKSUM XCP_CRC_32 MAX_BLOCK_SIZE 0x{size:X} /end CHECKSUM
            /begin PAGE 0 ECU_ACCESS_DONT_CARE XCP_READ_ACCESS_DONT_CARE
              XCP_WRITE_ACCESS_NOT_ALLOWED INIT_SEGMENT 0
            /end PAGE
            /begin PAGE 1 ECU_ACCESS_DONT_CARE XCP_READ_ACCESS_DONT_CARE
              XCP_WRITE_ACCESS_DONT_CARE INIT_SEGMENT 0
            /end PAGE
          /end SEGMENT
        /end IF_DATA
      /end MEMORY_SEGMENT
    /end MOD_PAR
"""


def a2l(program: Program, parameters: list[list[str]]) -> str:
    """The whole file."""
    ecu = program.address_of("sway_ecu_t")
    xcp = program.address_of("sway_xcp_t")
    working = xcp + program.offset_of("sway_xcp_t", "working")
    lists = next(int(re.search(r"\[(\d+)\]", v.name)[1]) for v in reversed(  # type: ignore[index]
        program.values("sway_xcp_daq_t")) if v.name.startswith("list[")) + 1  # fmt: skip
    words = program.values("sway_core_config_t")
    if len(words) != len(parameters) or any(w.offset != 4 * i for i, w in enumerate(words)):
        sys.exit(f"{program.path}: has {len(words)} parameters, the list {len(parameters)}")
    measured = [v for v in program.values("sway_ecu_t")
                if v.name.startswith(MEASURED) or v.name in ECU_FIELDS]  # fmt: skip
    order = "MSB_FIRST" if program.big_endian else "MSB_LAST"
    out = (
        'ASAP2_VERSION 1 61\n/begin PROJECT swaywatch ""\n  /begin MODULE swaywatch ""\n'
        f'    /begin MOD_COMMON "" BYTE_ORDER {order} ALIGNMENT_LONG 4 /end MOD_COMMON\n'
    )
    out += SEGMENT.format(address=working, size=4 * len(words))
    commands = "".join(f"        OPTIONAL_CMD {c}\n" for c in COMMANDS.split())
    out += INTERFACE.format(order=order, commands=commands, lists=lists)
    out += conversions([v.name for v in [*measured, *words]], program)
    out += "    /begin RECORD_LAYOUT word FNC_VALUES 1 SLONG COLUMN_DIR DIRECT /end RECORD_LAYOUT\n"
    out += "".join(measurement(v, ecu) for v in measured)
    out += "".join(
        characteristic(v, working, row) for v, row in zip(words, parameters, strict=True)
    )
    return out + "  /end MODULE\n/end PROJECT\n"


def main(elf: str, parameters: str, target: str) -> None:
    """Read, write."""
    rows = [line.split() for line in Path(parameters).read_text().splitlines()]
    Path(target).write_text(a2l(Program(Path(elf)).read(), rows))


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
