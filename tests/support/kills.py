"""Runs killed in mid-march, and what is left of them: `python tests/support/kills.py --count 200`.

Each run is marched by a process of its own and killed at a random moment, half of them within
milliseconds of a write. What is left must open, be the first records of a run that nobody killed,
to the bit, and lack no more than one flush; of some it is also seen that they go on to its end.
"""

import argparse
import multiprocessing
import random
import shutil
import tempfile
import time
from pathlib import Path

import numpy as np
import xarray as xr
from small_run import RECORDED, small

import bladewhirl as bw
from bladewhirl.models.case.case import Case
from bladewhirl.postprocess.fields.result import ResultError
from bladewhirl.solvers.march.checkpoint import CHECKPOINT_NAME, read_checkpoint
from bladewhirl.solvers.march.march import CHUNK_STEPS
from bladewhirl.solvers.march.schema import RESULT_NAME
from bladewhirl.studies.runs.recorded_march import FLUSH_RECORDS
from bladewhirl.studies.runs.run import resume

RECORD_STEPS = 2e-5, 1e-4
DURATION = 0.6  #: of each march [s]
PAUSE = 0.03  #: after each chunk of steps, so that a march lasts longer than its flushes [s]
LONGEST = 1.5  #: from the first records to a kill [s]
NEAR = 0.02  #: from a write to a kill aimed at it [s]
GO_ON = 10  #: one of so many is resumed


def killed(case: Case, folder: Path, chance: random.Random) -> int:
    """Begin a run in a process of its own and kill it; the steps that it had done."""
    fork = multiprocessing.get_context("fork")
    steps = fork.RawValue("q", 0)

    def progress(activity: str, done: int, total: int) -> None:
        steps.value = done
        time.sleep(PAUSE)

    march = {"frames": 0, "progress": progress}
    child = fork.Process(target=bw.run, args=(case, folder), kwargs=march)
    child.start()
    result = folder / RESULT_NAME
    while not result.exists():
        time.sleep(1e-4)
    time.sleep(chance.uniform(0.0, LONGEST))
    if chance.random() < 0.5:
        size, latest = result.stat().st_size, time.monotonic() + LONGEST
        while result.stat().st_size == size and time.monotonic() < latest:
            time.sleep(1e-4)
        time.sleep(chance.uniform(0.0, NEAR))
    child.kill()
    child.join()
    return int(steps.value)


def look(folder: Path, whole: xr.Dataset, steps: int, every: int) -> int:
    """See that what is left is right; the number of records that were lost."""
    checkpoint = folder / CHECKPOINT_NAME
    try:
        with bw.open_result(folder) as left:
            kept = left.sizes["time"]
            for name in RECORDED:
                np.testing.assert_array_equal(left[name].values, whole[name].values[:kept], name)
    except ResultError:  # in a sentence, before the first flush only
        assert steps == 0
        assert not checkpoint.exists()
        return 0
    lost = max(0, 1 + (steps - 1) // every - kept)
    assert lost <= FLUSH_RECORDS + CHUNK_STEPS // every, f"{lost} records lost"
    assert not checkpoint.exists() or read_checkpoint(checkpoint).records <= kept
    return lost


def kill(count: int) -> str:
    """Kill so many runs; what came of it, in words."""
    lost: list[int] = []
    resumed = 0
    with tempfile.TemporaryDirectory(prefix="kills-") as place:
        whole = {}
        for step in RECORD_STEPS:
            case = small(**{"march.record_step": step, "march.duration": DURATION})
            with bw.open_result(bw.run(case, Path(place) / f"{step}", frames=0).directory) as run:
                whole[step] = case, run.load()
        for number in range(count):
            chance = random.Random(number)
            step = RECORD_STEPS[number % len(RECORD_STEPS)]
            case, expected = whole[step]
            folder = Path(place) / "run"
            steps = killed(case, folder, chance)
            lost.append(look(folder, expected, steps, round(step / case.march.time_step)))
            if number % GO_ON == 0 and (folder / CHECKPOINT_NAME).exists():
                resume(folder, frames=0)
                with bw.open_result(folder) as left:
                    xr.testing.assert_equal(left[RECORDED], expected[RECORDED])
                resumed += 1
            shutil.rmtree(folder)
    return (
        f"{count} kills: all read, {max(lost)} records lost at most, {resumed} resumed to the end"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Kill runs and look at what is left.")
    parser.add_argument("--count", type=int, default=20)
    print(kill(parser.parse_args().count))
