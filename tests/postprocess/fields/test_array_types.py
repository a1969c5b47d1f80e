"""Arrays of other libraries are told from NumPy's, and the libraries aren't loaded for that."""

import subprocess
import sys

PROGRAM = """
import sys
import xarray as xr
import bladewhirl.postprocess.fields.netcdf
table = xr.Dataset({"a": ("x", [1.0, 2.0])}, {"x": [0, 1]})
table["a"].sum().values, table.isel(x=0), str(table)
assert not {"dask.array", "pint"} & set(sys.modules)
assert table.chunk(x=1)["a"].chunksizes == {"x": (1, 1)}
from pint import Quantity
from xarray.namedarray.pycompat import array_type, mod_version
assert xr.Variable("x", Quantity([1.0, 2.0], "m")).to_numpy().tolist() == [1.0, 2.0]
assert array_type("pint") == (Quantity,) and mod_version("dask").major > 2000
"""


def test_libraries_are_asked_once_they_are_loaded() -> None:
    subprocess.run([sys.executable, "-c", PROGRAM], check=True)
