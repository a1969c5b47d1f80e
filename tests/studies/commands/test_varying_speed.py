"""Commands at one speed with a case whose speed varies: they state the speed that they use."""

from pathlib import Path

import pytest
import rod_blade
from command_line import answer
from places import EXAMPLES

import bladewhirl as bw

RISING = 'march.run_up={from="1000 rpm",to="3000 rpm",end="1 s"}'
FREE = 'march={speed="2500 rpm",drive={inertia=1.0}}'
FAN = str(EXAMPLES / "spinning_fan.toml")
FEW = ("--set", "bladed_disk.blades=8", "--set", "bladed_disk.elements_per_blade=3")


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        ("modes", FAN, "--count", "1"),
        ("campbell", FAN, "--json"),
        ("critical-speeds", FAN, "--json"),
        ("stability", FAN, "--speed", "1", "--kappa", "100", "--json"),
        ("show", FAN, "--json"),
    ],
)
def test_the_speed_of_a_study_is_stated(command: tuple[str, ...]) -> None:
    result = answer(*command, *FEW, "--set", RISING)
    assert "those at 3000 rpm, the fastest speed of march.run_up" in result.stderr
    result = answer(*command, *FEW, "--set", "excitation.ramp=0", "--set", FREE)
    assert "those at 2500 rpm, march.speed, at which the free speed starts" in result.stderr
    result = answer(*command, *FEW)
    assert "the speed varies" not in result.stderr


def test_a_loss_of_blades_has_no_periodic_motion(tmp_path: Path) -> None:
    bw.write_superelement(tmp_path / "rods.npz", rod_blade.blade())
    given = rod_blade.tables(tmp_path / "rods.npz", blade_loss={"blade": 1, "time": 0.01})
    with pytest.raises(bw.UserError, match=r"blades are lost; remove \[blade_loss\]"):
        bw.periodic(bw.case_from(given))
