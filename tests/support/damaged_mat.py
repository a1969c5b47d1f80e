"""Random .mat files: `python tests/support/damaged_mat.py FOLDER COUNT` reads COUNT of them.

Run in a process of its own, because a reader that trusts the bytes of a file ends the process. Each
file is a good one with a few wrong bytes.
"""

import random
import sys
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io as sio
import scipy.sparse as sp

from bladewhirl.models.imports.importing import import_superelement
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.superelements.file import read_superelement

WORDS = (10**9, -5, 2**31 - 1, -1, 0, 1, 100)
NUMBERS = (np.nan, np.inf, 1e300, 1e-300, -1.0, 0.5)


def good(folder: Path) -> list[bytes]:
    """Return the bytes of good files: sparse, full, compressed, in a structure, of version 4."""
    size = 9
    mass, stiffness = sp.csc_array(0.1 * np.eye(size)), sp.csc_array(1e6 * np.eye(size))
    contact = {"contact_position": np.array([[0.3, 0.0, 0.0]]), "contact_dofs": [[0, 1, 2]]}
    matrices = {"mass": mass, "stiffness": stiffness}
    full = {key: matrix.toarray() for key, matrix in matrices.items()}
    variants: list[tuple[dict[str, Any], dict[str, Any]]] = [
        (matrices, {}),
        (matrices, {"do_compression": True}),
        ({"model": {"M": mass, "K": stiffness}}, {}),
        (matrices, {"format": "4"}),
        (full | {"length_unit": "m"}, {}),
    ]
    files = []
    for number, (content, options) in enumerate(variants):
        path = folder / f"good{number}.mat"
        sio.savemat(path, content | contact, **options)
        import_superelement(path)
        files.append(path.read_bytes())
    return files


def damaged(content: bytes, chance: random.Random) -> bytes:
    """Return the bytes of a file with some of them changed or removed."""
    changed = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 4, 10, 40))):
        at = chance.randrange(116 if chance.random() < 0.8 else 0, len(changed))
        match chance.randrange(4):
            case 0:
                changed[at] = chance.randrange(256)
            case 1:
                changed[at : at + 4] = chance.choice(WORDS).to_bytes(4, "little", signed=True)
            case 2:
                changed[at : at + 8] = np.float64(chance.choice(NUMBERS)).tobytes()
            case 3 if len(changed) > 300:
                del changed[at : at + chance.choice((1, 4, 8))]
    return bytes(changed)


def main(folder: Path, count: int) -> None:
    """Read damaged files; print how many were refused."""
    files, refused = good(folder), 0
    path = folder / "damaged.mat"
    for number in range(count):
        chance = random.Random(number)
        path.write_bytes(damaged(chance.choice(files), chance))
        for read in (read_superelement, import_superelement):
            try:
                part = read(path)
                part.stiffness @ np.ones(part.size)
            except UserError:
                refused += 1
    print(refused)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
