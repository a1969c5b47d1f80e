"""Pages in a real browser: they load nothing, and run nothing but their own program."""

import re
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
from three_runs import KINDS, Kind, run_of

import bladewhirl as bw
from bladewhirl.postprocess.pictures.render import animation_records
from bladewhirl.postprocess.pictures.web_page import render_page
from bladewhirl.postprocess.plotting.style import save_figure
from bladewhirl.postprocess.run.figures import RunFigures

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), ""
)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.pictures,
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


def browsed(path: Path, script: str = "") -> str:
    """Return the document of a page after it has run, with a script that acts as a user does."""
    if script:
        text = path.read_text(encoding="utf-8")
        own = f"<script>{ACTING}\n(async () => {{ {script} }})();</script>"
        path = path.with_name(f"used_{path.name}")
        path.write_text(text.replace("</body>\n</html>", f"{own}</body></html>"), encoding="utf-8")
    options = f"{OPTIONS} user-data-dir={path.parent / 'profile'}".split(" ")
    command = [BROWSER, *(f"--{option}" for option in options), path.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "CONSOLE" not in done.stderr, done.stderr  # no error of its own, nothing refused
    return done.stdout


OPTIONS = (
    "headless no-sandbox use-gl=angle use-angle=swiftshader enable-unsafe-swiftshader"
    " window-size=1200,900 virtual-time-budget=8000 dump-dom enable-logging=stderr"
)
ACTING = """
const wait = time => new Promise(done => setTimeout(done, time));
const told = (name, value) => { document.body.dataset[name] = value; };
const point = (at, kind, x, y, more = {}) => {
  const { left, top } = at.getBoundingClientRect();
  const place = { clientX: left + x, clientY: top + y, bubbles: true };
  at.dispatchEvent(new PointerEvent(kind, { ...place, ...more }));
};
"""
"""Script of the page of a test: pauses, results as attributes of the body, events."""


def results(document: str) -> dict[str, str]:
    """Return what a script has told."""
    body = re.search(r"<body([^>]*)>", document)
    assert body is not None
    return {name: unescape(text) for name, text in re.findall(r'data-(\w+)="([^"]*)"', body[1])}


@pytest.mark.parametrize("kind", KINDS)
def test_a_film_plays_turns_and_is_pointed_at(kind: Kind, tmp_path: Path) -> None:
    """Beams move when dragged, surfaces turn; a click on the curve of the force is an instant."""
    run = run_of(kind)
    records = animation_records(run, frames=20)
    path = render_page(run, tmp_path / "film.html", records, colour="stress")
    seen = results(
        browsed(
            path,
            """await wait(800);
            const first = frame;
            tick(performance.now() + 9000);
            told("played", frame === (first + 1) % about.times.length);
            stopAt(7);
            const before = turn.join(), moved = shift.join();
            point(canvas, "pointermove", 300, 300, { buttons: 1, movementX: 80, movementY: 30 });
            told("turned", turn.join() !== before);
            told("moved", shift.join() !== moved);
            all();
            const half = 14 + curve.clientWidth / 2;
            curve.dispatchEvent(new MouseEvent("click", { clientX: half }));
            told("frame", frame);
            told("frames", about.times.length);
            let found = "";
            for (let x = 20; x < canvas.clientWidth && !found; x += 15)
              for (let y = 20; y < canvas.clientHeight - 100 && !found; y += 15) {
                point(canvas, "pointermove", x, y);
                found = document.getElementById("hover").textContent;
              }
            told("hover", found);
            const seen = new Uint8Array(4 * 200 * 200);
            const [x, y] = [solid.width / 2, solid.height / 2];
            draw();
            if (gl) gl.readPixels(x - 100, y - 100, 200, 200, gl.RGBA, gl.UNSIGNED_BYTE, seen);
            told("drawn", new Set(seen).size);""",
        )
    )
    solid = kind != "beams"
    assert seen["played"] == "true"
    assert (seen["turned"], seen["moved"]) == (("true", "false") if solid else ("false", "true"))
    assert abs(int(seen["frame"]) - (int(seen["frames"]) - 1) / 2) <= 1
    assert "blade" in seen["hover"] or "casing" in seen["hover"]
    assert "MPa" in seen["hover"] or "Pa" in seen["hover"]
    assert int(seen["drawn"]) > (10 if solid else 0)


def test_figures_state_the_value_under_the_pointer(tmp_path: Path) -> None:
    figure, data = RunFigures(run_of("beams")).draw("haigh")
    (path,) = save_figure(figure, tmp_path / "haigh", formats=["html"])
    seen = results(
        browsed(
            path,
            """await wait(300);
            const picture = document.querySelector("img"), box = picture.getBoundingClientRect();
            const [panel] = JSON.parse(document.getElementById("values").textContent);
            const shown = document.getElementById("hover-tip");
            const [x, y] = panel.curves[panel.curves.length - 1].points[0].map(at => at / 10000);
            point(picture, "pointermove", x * box.width + 2, y * box.height + 2);
            told("tip", shown.textContent);
            point(picture, "pointerleave", 0, 0);
            told("gone", shown.style.display);""",
        )
    )
    worst = data.isel(blade=data.attrs["worst"])
    lines = dict(line.rsplit(": ", 1) for line in seen["tip"].splitlines())
    for name, label in (
        ("mean", "mean surface stress [MPa]"),
        ("alternating", "alternating stress [MPa]"),
    ):
        assert float(lines[label]) == pytest.approx(1e-6 * float(worst[name]), rel=0.01, abs=0.3)
    assert seen["gone"] == "none"


@pytest.mark.parametrize(
    ("make", "drawn"),
    [
        (run_page, ["<iframe", 'id="hover-tip"']),
        (sweep_page, ['id="hover-tip"', "sustained"]),
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
    seen = browsed(path)
    assert 'id="ran"' not in seen
    assert requests == []
    assert title in unescape(seen.partition("</title>")[0])
    for words in drawn:
        assert words in seen
