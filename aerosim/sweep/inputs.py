"""Files of the user that a sweep reads, and a digest of what is in each: a changed file makes other runs."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from aerosim.scenario.load import FILE_KEYS

WHOLE = 256 << 20  # bytes up to which a file is read whole: some 0.3 s
EDGE = 1 << 20  # bytes of each end that are read of a larger one
MODEL = (".xml", ".yaml")  # files that an aircraft's folder is read for


def leaves(tree: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Values of nested mappings by dotted key."""
    for name, value in tree.items():
        if isinstance(value, Mapping):
            yield from leaves(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def is_file(key: str, value: Any) -> bool:
    """Whether the value of a dotted key is a path.  A bare word is the name of something that ships."""
    return key in FILE_KEYS and isinstance(value, str) and Path(value).is_absolute()


def files_in(tree: Mapping[str, Any]) -> list[str]:
    """Paths of the user's files and folders that values name.  tree: values by dotted key, or nested mappings."""
    return [value for key, value in leaves(tree) if is_file(key, value)]


def may_name_file(key: str) -> bool:
    """Whether the value of a dotted key may hold the path of a file."""
    return any(f"{name}.".startswith(f"{key}.") for name in FILE_KEYS)


def content(path: Path) -> str | None:
    """Digest of a file or of an aircraft's folder; None if it cannot be read.

    Of a file beyond 256 MB it is taken from its size, the time of its last change, and its first and last MB: to
    read 10 GB of terrain takes longer than many a sweep.
    """
    try:
        if not path.is_dir():
            return _of_file(path)
        out = hashlib.sha256()
        for file in sorted(each for each in path.rglob("*") if each.suffix in MODEL):
            out.update(f"{file.relative_to(path).as_posix()} {_of_file(file)};".encode())
        return out.hexdigest()[:32]
    except OSError:
        return None


def _of_file(file: Path) -> str:
    with file.open("rb") as stream:
        size = stream.seek(0, 2)
        stream.seek(0)
        if size <= WHOLE:
            return hashlib.file_digest(stream, "sha256").hexdigest()[:32]
        out = hashlib.sha256(f"{size} {file.stat().st_mtime_ns};".encode() + stream.read(EDGE))
        stream.seek(size - EDGE)
        out.update(stream.read(EDGE))
        return out.hexdigest()[:32]
