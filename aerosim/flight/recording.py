"""A flight as it is kept: every step, bit for bit, in blocks of half their size; and as the bytes of a file."""

from __future__ import annotations

import hashlib
import json
import struct
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.flight.plan import FlightPlan, Line
from aerosim.frames import Array

STATE_WIDTH = 15
"""AircraftState and cross-track."""
EVENT_WIDTH = 13
"""Step in the block, AirState, line, next line, number of the phase."""
_MAGIC = b"aerosim flight 1\n"
_LENGTH = struct.Struct("<Q")


class Block(NamedTuple):
    """Steps `first` to first + steps - 1: states (steps, 15) and events (events, 13), packed."""

    first: int
    steps: int
    events: int
    states: bytes
    changes: bytes

    def unpacked(self) -> tuple[Array, Array]:
        """States (steps, 15), and events (events, 13), the first of them at the block's first step."""
        return unpack(self.states, (self.steps, STATE_WIDTH)), unpack(self.changes, (self.events, EVENT_WIDTH))


@dataclass(frozen=True)
class Recording:
    """A flight that was flown.  plan: as it tells it.  failure: why it did not go on after its last step."""

    plan: FlightPlan
    blocks: tuple[Block, ...]
    failure: str

    @property
    def last(self) -> int:
        """Number of the last step."""
        return self.blocks[-1].first + self.blocks[-1].steps - 1

    @property
    def size(self) -> int:
        """Bytes, nearly."""
        return sum(len(block.states) + len(block.changes) for block in self.blocks)


@cache
def _codec() -> Any:
    import pyarrow as pa

    return pa.Codec("zstd", compression_level=1)


def pack(table: Array) -> bytes:
    """A table (n, k) of numbers in few bytes, without loss.

    The second differences of the bit patterns of a smooth column are small; bytes of equal weight stand together.
    """
    bits = np.ascontiguousarray(table.T, np.float64).view(np.int64)
    for _ in range(2):
        bits = np.diff(bits, axis=1, prepend=np.int64(0))
    folded = (bits << 1) ^ (bits >> 63)
    return bytes(_codec().compress(folded.view(np.uint8).reshape(-1, 8).T.tobytes(), asbytes=True))


def unpack(packed: bytes, shape: tuple[int, int]) -> Array:
    """The table (n, k) that was packed.  Raises ValueError or OSError for bytes that are none."""
    rows, columns = shape
    raw = _codec().decompress(packed, rows * columns * 8, asbytes=True)
    planes = np.frombuffer(raw, np.uint8).reshape(8, -1)
    folded = np.ascontiguousarray(planes.T).view(np.uint64).reshape(columns, rows)
    bits: NDArray[np.int64] = (folded >> np.uint64(1)).view(np.int64) ^ -(folded & np.uint64(1)).view(np.int64)
    for _ in range(2):
        np.cumsum(bits, axis=1, out=bits)
    return np.ascontiguousarray(bits.view(np.float64).T)


def to_bytes(recording: Recording) -> bytes:
    """The file of a recording."""
    plan, blocks = recording.plan, recording.blocks
    head = {
        "lines": [[*line.start, *line.end] for line in plan.lines],
        "plan": [plan.height, plan.airspeed, plan.run_in_s, plan.bank_max],
        "failure": recording.failure,
        "blocks": [[b.first, b.steps, b.events, len(b.states), len(b.changes)] for b in blocks],
    }
    text = json.dumps(head).encode()
    body = b"".join([_MAGIC, _LENGTH.pack(len(text)), text, *(b.states + b.changes for b in blocks)])
    return body + hashlib.sha256(body).digest()


def from_bytes(data: bytes) -> Recording:
    """The recording in a file.  Raises ValueError if the file is damaged, cut off, or something else."""
    body, digest = data[:-32], data[-32:]
    if not body.startswith(_MAGIC) or hashlib.sha256(body).digest() != digest:
        raise ValueError("not a whole recording")
    at = len(_MAGIC) + _LENGTH.size
    (length,) = _LENGTH.unpack_from(body, len(_MAGIC))
    head, at = json.loads(body[at : at + length]), at + length
    blocks = []
    for first, steps, events, states, changes in head["blocks"]:
        parts = body[at : at + states], body[at + states : at + states + changes]
        blocks.append(Block(first, steps, events, *parts))
        at += states + changes
    lines = [Line((a, b), (c, d)) for a, b, c, d in head["lines"]]
    return Recording(FlightPlan(lines, *head["plan"]), tuple(blocks), head["failure"])
