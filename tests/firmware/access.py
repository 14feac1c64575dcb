"""What a tester needs to change parameters over CAN: SipHash, the block, challenge and proof.

Written from port/README.md, "Who may write", and shares no code with port/.
"""

from __future__ import annotations

import zlib

KEY = b"swaywatch replay"
"""Of the replay programs (port/replay/replay.c)."""
MASK = (1 << 64) - 1


def _turn(word: int, by: int) -> int:
    return (word << by | word >> (64 - by)) & MASK


def _rounds(v: list[int], count: int) -> None:
    for _ in range(count):
        v[0] = (v[0] + v[1]) & MASK
        v[1] = _turn(v[1], 13) ^ v[0]
        v[0] = _turn(v[0], 32)
        v[2] = (v[2] + v[3]) & MASK
        v[3] = _turn(v[3], 16) ^ v[2]
        v[0] = (v[0] + v[3]) & MASK
        v[3] = _turn(v[3], 21) ^ v[0]
        v[2] = (v[2] + v[1]) & MASK
        v[1] = _turn(v[1], 17) ^ v[2]
        v[2] = _turn(v[2], 32)


def siphash(key: bytes, message: bytes) -> bytes:
    """SipHash-2-4 (Aumasson and Bernstein 2012), lowest byte first."""
    k = [int.from_bytes(key[i : i + 8], "little") for i in (0, 8)]
    start = (0x736F6D6570736575, 0x646F72616E646F6D, 0x6C7967656E657261, 0x7465646279746573)
    v = [start[i] ^ k[i % 2] for i in range(4)]
    padded = message + bytes(7 - len(message) % 8) + bytes([len(message) % 256])
    for at in range(0, len(padded), 8):
        word = int.from_bytes(padded[at : at + 8], "little")
        v[3] ^= word
        _rounds(v, 2)
        v[0] ^= word
    v[2] ^= 0xFF
    _rounds(v, 4)
    return (v[0] ^ v[1] ^ v[2] ^ v[3]).to_bytes(8, "little")


def with_values(block: bytes, sequence: int, words: dict[int, int]) -> bytes:
    """Return a parameter block with another sequence number and some other words."""
    made = bytearray(block[:-4])
    made[8:12] = sequence.to_bytes(4, "little")
    for index, value in words.items():
        made[12 + 4 * index : 16 + 4 * index] = value.to_bytes(4, "little", signed=True)
    return bytes(made) + zlib.crc32(made).to_bytes(4, "little")


def challenge(key: bytes, time_us: int, sequence: int) -> bytes:
    """Return what an ECU without noise asks, so that a recording can hold the answer."""
    moment = time_us.to_bytes(8, "little") + sequence.to_bytes(4, "little") + bytes(4)
    return siphash(key, moment)[:6]


def proof(key: bytes, asked: bytes, command: int, block: bytes) -> tuple[int, int]:
    """Return index and value of the request that ends a session."""
    made = siphash(key, asked + bytes([command, 0]) + block)
    return int.from_bytes(made[:2], "little"), int.from_bytes(made[2:6], "little", signed=True)
