"""The casing over time in a report: bytes are the stored values."""

import base64

import numpy as np
import pytest
from three_runs import KINDS, Kind, run_of

from bladewhirl.postprocess.reports.player import SHADES, player
from bladewhirl.postprocess.run.unrolled import unrolled


@pytest.mark.parametrize("kind", KINDS)
def test_shades_are_the_values(kind: Kind) -> None:
    data = unrolled(run_of(kind))
    block = player(data)
    assert len(block.times) == data.sizes["span"]
    force = data["force"].fillna(0.0).values
    assert force[block.start].max() == force.max()
    names = ["gap", "force", *(["wear"] if kind != "wheel" else [])]
    assert len(block.rows) == len(names)
    for name, row in zip(names, block.rows, strict=True):
        shades = np.frombuffer(base64.b64decode(row["shades"]), dtype=np.uint8)
        shades = shades.reshape(row["shape"])[:, ::-1]
        values = data[name].values
        unit = {"m": 1e-3, "µm": 1e-6, "mm": 1e-3, "N": 1.0, "kN": 1e3}[
            row["label"].split("[")[1][:-1]
        ]
        top = unit * row["top"]
        assert top == pytest.approx(np.nanmax(values))
        if values.shape[2] == shades.shape[2]:
            assert np.array_equal(shades > SHADES, np.isnan(values))
            known = ~np.isnan(values)
            np.testing.assert_allclose(
                top * shades[known] / SHADES, values[known], atol=0.51 * top / SHADES
            )
        colours = np.frombuffer(base64.b64decode(row["colours"]), dtype=np.uint8).reshape(-1, 3)
        assert colours[0].tolist() == [255, 255, 255]
        assert colours[-1].sum() < colours[100].sum() < colours[1].sum()
