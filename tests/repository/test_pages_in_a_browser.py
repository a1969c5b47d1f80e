"""Pages in a real browser: they load nothing, and run nothing but their own program."""

import shutil
import subprocess
from collections.abc import Callable, Iterator
from html import unescape
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from synthetic_result import synthetic_result
from synthetic_sweep import synthetic_sweep

import bladewhirl as bw
from bladewhirl.postprocess.pictures.web_page import render_page

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), ""
)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not BROWSER, reason="no chromium or chrome is installed"),
]

HOSTILE = (
    "<!--<script>@PLACES@ {{ 7 * 7 }} </script><script>document.body.id = 'ran'</script>"
    "<img src='PLACE/image.png' onerror=\"document.body.id = 'ran'\">"
    "<link rel=stylesheet href=PLACE/a.css><iframe src=PLACE/a.html></iframe>\u2028'\"\\"
)


@pytest.fixture(scope="module")
def asked() -> Iterator[tuple[str, list[str]]]:
    """Address of a server, and what is asked of it."""
    actual: list[str] = []

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            actual.append(self.path)
            self.send_error(404)

        def log_message(self, format: str, *args: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}", actual
    server.shutdown()
    server.server_close()


def run_page(folder: Path, title: str) -> Path:
    """A report of a run."""
    run = folder / "run"
    run.mkdir()
    result = synthetic_result(records=60, shaft_radius=1.2e-3).assign_attrs(
        title=title, case=f"# {title}"
    )
    result.to_netcdf(run / "result.nc", engine="h5netcdf")
    return bw.report(run)


def sweep_page(folder: Path, title: str) -> Path:
    """A report of a sweep, one point of which failed."""
    motions = [{"speed": 75.0, "shaft_radius": 1.2e-3, "records": 200}, None]
    made = synthetic_sweep(
        folder / "sweep", {"march.speed": (1.0, 1.2)}, motions, case=f"# {title}", title=title
    )
    return bw.report(made)


def animation(folder: Path, title: str) -> Path:
    """A film to point at."""
    result = synthetic_result(records=20).assign_attrs(title=title)
    return render_page(result, folder / "film.html", np.array([0, 9, 19]))


@pytest.mark.parametrize(
    ("make", "drawn"),
    [
        (run_page, ['class="main-svg"', "blades in contact, largest force"]),
        (sweep_page, ['class="main-svg"', "sustained (1)"]),
        (animation, []),
    ],
)
def test_titles_and_cases_are_words(
    make: Callable[[Path, str], Path],
    drawn: list[str],
    asked: tuple[str, list[str]],
    tmp_path: Path,
) -> None:
    place, requests = asked
    title = HOSTILE.replace("PLACE", place)
    path = make(tmp_path, title)
    options = "headless no-sandbox disable-gpu virtual-time-budget=5000 dump-dom".split()
    options += [f"user-data-dir={tmp_path / 'profile'}", "enable-logging=stderr"]
    command = [BROWSER, *(f"--{option}" for option in options), path.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    seen = done.stdout
    assert 'id="ran"' not in seen
    assert requests == []
    assert "CONSOLE" not in done.stderr, done.stderr  # no error of its own, nothing refused
    assert title in unescape(seen.partition("</title>")[0])
    for words in drawn:
        assert words in seen
