"""Opening of HDF5 files that others may have written, with their own data of a plausible size.

HDF5 reads any file that a link, external storage or a virtual dataset names.
"""

from io import RawIOBase
from os import PathLike, stat

import h5py
import numpy as np

from bladewhirl.files import check_regular

ROOM, DENSEST = 1e9, 100
"""A file whose arrays declare more than `ROOM` bytes and more than `DENSEST` times the size of the
file is rejected as damaged."""

LIST = h5py.vlen_dtype(h5py.ref_dtype)  #: type of the list of the dimensions of a variable


def open_hdf5(
    path: str | PathLike[str], mode: str = "r", stream: RawIOBase | None = None, kinds: str = ""
) -> h5py.File:
    """Open an HDF5 file, perhaps through a file object; `kinds` are the kinds of numbers, as in
    NumPy, that its arrays may have, any by default.

    Raises:
        OSError: it cannot be opened, or has data in other files, of other kinds, or too many.
    """
    check_regular(path)
    h5 = h5py.File(path if stream is None else stream, mode)
    try:
        own = h5py.HardLink | h5py.SoftLink
        foreign = h5.visititems_links(lambda name, link: None if isinstance(link, own) else name)
        if foreign is not None:
            raise ValueError(f"{foreign} is in another file")
        sizes = [_size("", h5, kinds)]
        h5.visititems(lambda name, each: sizes.append(_size(name, each, kinds)))
        declared, size = sum(sizes), stat(path).st_size
        if declared > max(ROOM, DENSEST * size):
            raise ValueError(
                f"it declares {declared:.3g} bytes of data in a file of {size:.3g} bytes"
            )
    except Exception as error:  # HDF5 raises many kinds for damaged bytes
        h5.close()
        raise OSError(str(error)) from None
    return h5


def _size(name: str, stored: h5py.Group | h5py.Dataset, kinds: str) -> float:
    """Return the size of an array, or of a chunk of it if this is larger [bytes]; 0 for a group.

    Objects must be text or, in the list of dimensions of netCDF, references: HDF5 ends the process
    where damage turns text into an array of variable length.
    """
    types = {key: stored.attrs.get_id(key).dtype for key in stored.attrs}
    array = isinstance(stored, h5py.Dataset)
    if h5py.check_vlen_dtype(types.pop("DIMENSION_LIST", LIST)) != h5py.ref_dtype or any(
        kind.kind == "O" and h5py.check_string_dtype(kind) is None
        for kind in (*types.values(), *([stored.dtype] if array else []))
    ):
        raise ValueError(f"{name} has neither numbers nor text")
    if not array:
        return 0.0
    if stored.is_virtual or stored.external:
        raise ValueError(f"{name} is in another file")
    if kinds and stored.dtype.base.kind not in kinds:
        raise ValueError(f"{name} has no numbers")
    longest = max(np.prod(each, dtype=float) for each in (stored.shape or (), stored.chunks or ()))
    return float(longest * stored.dtype.itemsize)
