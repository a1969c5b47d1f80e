"""Panel next to the stage in a picture: title, time, contact, colour scale, orbit of the shaft."""

import textwrap
from collections.abc import Mapping

import numpy as np
import pyvista
import xarray as xr

from bladewhirl.meshes.plane import directions
from bladewhirl.models.inputs.units import handy
from bladewhirl.postprocess.fields.by_blade import blade_starts
from bladewhirl.postprocess.fields.enlarged import rounded_down
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.labelled import LOSS
from bladewhirl.postprocess.fields.lost_blades import lost_blades
from bladewhirl.postprocess.pictures import appearance as look
from bladewhirl.postprocess.pictures.drawing import Picture, number_places
from bladewhirl.postprocess.pictures.scene import CIRCLE, StageScene, disc_triangles
from bladewhirl.postprocess.pictures.symbols import KINDS, Symbols, sample

#: upper edges of the texts, relative to the height of the window
TOPS = {
    "title": 0.97,
    "time": 0.885,
    "speed": 0.82,
    "frame": 0.715,
    "contact": 0.565,
    "orbit": 0.475,
}
#: upper and lower edge of the colour scale or of the key of colours, relative to the window
SCALE_TOP, SCALE_FOOT = 0.455, 0.105
SCALE_WIDTH, SCALE_ASIDE = 0.018, 0.115  #: width of a scale, and distance of two, likewise
TICKS, SHORT = (5, 3), 0.15
"""Numbers of ticks of a long and of a short scale, and the height of the latter, likewise."""
ORBIT_SIZE = 0.17  #: size of the inset with the orbit, relative to the window
LINE = (0.77, 0.98, 0.01, 0.036)  #: left, right, lower, upper edge of the time line, likewise
LINE_TOP = 0.082  #: upper edge of its text
BAR_SHARE = 0.11  #: longest scale bar, relative to the width of the window
BAR_FOOT, BAR_STEP = 0.044, 0.0205  #: lower edge of the text of the scale bar, and height of a line
LETTERS = 2.4  #: size of blade numbers in a sheet, relative to their size in a single picture
KEY_STEP = 0.034
KEY_LETTERS, TITLE_LETTERS = 27, 24
ON_PLANE = ((0, 0), (0, 1))  #: padding of points (point, 2) with a zero third coordinate


class Panel:
    """Texts and colour scale to the right of the stage.

    Args:
        scene: the stage.
        dataset: a result.
        note: additional line of text.
        trail: consecutive records, for which an inset shows the orbit of the shaft; None for no
            inset.
        sheet: true for a picture of a sheet: blade numbers are larger, and the panel states the
            length of the scale bar.
    """

    def __init__(
        self,
        scene: StageScene,
        dataset: xr.Dataset,
        *,
        note: str = "",
        trail: IntArray | None = None,
        sheet: bool = False,
    ) -> None:
        self._plotter, drawing = scene.plotter, scene.drawing
        self._drawing = drawing
        size = look.enlargement(drawing.exaggeration, normalised=drawing.normalised)
        shown = [f"{drawing.frame} frame", size]
        bar = draw_scale_bar(scene, "" if drawing.normalised else "motion, clearance")
        lost = lost_blades(dataset)
        if lost is not None:
            shown.append(str(dataset.attrs[LOSS]))
        if sheet:
            shown.append(f"bars: {bar}")
        else:
            shown += [*drawing.discs, *drawing.dots]
            write_bar(scene, bar)
        write_title(scene.plotter, dataset)
        self._time = write(scene.plotter, "", TOPS["time"], 22)
        self._touches = "contact_impulse" in dataset  # not in a mode
        self._speed = write(scene.plotter, "", TOPS["speed"], 13)
        self._reference = float(dataset.attrs["reference_frequency"])
        write(
            scene.plotter,
            "\n".join(filter(None, [*shown, note])),
            TOPS["frame"],
            13,
            color=look.FAINT,
        )
        self._contact = write(scene.plotter, "", TOPS["contact"], 14, color=look.FORCE_COLOUR)
        self._orbit = None if trail is None else Orbit(scene, dataset, trail)
        films = len(drawing) > 2 and not sheet
        self._line = TimeLine(scene, lost.time if lost else None) if films else None
        self._numbers = BladeNumbers(scene, blade_starts(dataset), LETTERS if sheet else 1.0)
        limit = drawing.linear_limit()
        if limit is not None:
            words = f"blades bend by more than\n{handy(limit, 'm', 3)}: a linear model"
            words += "\nis off by a tenth or more"
            write(scene.plotter, words, 0.075, 11, color=look.FORCE_COLOUR, indent=-0.205)
        top = SCALE_TOP if trail is None else TOPS["orbit"] - 0.06 - ORBIT_SIZE
        if drawing.colouring.parts is None:
            write_scales(scene, top)
        else:
            write_key(scene.plotter, drawing.colouring.parts, top)

    def show(self, picture: Picture) -> None:
        """Update time, speed, contact text, blade numbers and orbit."""
        self._time.input = look.time_text(picture.time, self._drawing.record_step)
        self._show_speed(picture.speed)
        if self._touches:
            touched = bool(np.any(picture.blade_forces))
            self._contact.input = look.contact_text(picture.blade_forces, self._drawing.record_step)
            self._contact.prop.color = look.FORCE_COLOUR if touched else look.FAINT
        self._numbers.show(picture)
        for inset in (self._orbit, self._line):
            if inset is not None:
                inset.show(picture.time)

    def show_all(self) -> None:
        """Show the time window, speeds and the largest force of all records instead of one."""
        self._show_speed(*self._drawing.speeds)
        first, last = 1e3 * self._drawing.times[[0, -1]]
        largest = self._drawing.largest_force
        self._time.input = f"{first:.4g} to {last:.4g} ms"
        arrows = f"arrows: contact forces,\nlargest {handy(largest, 'N', 3)}"
        self._contact.input = arrows if largest else "no contact at these times"

    def _show_speed(self, *speeds: float) -> None:
        if any(speeds):  # zero for a mode
            self._speed.input = f"speed\n{look.speed_text(self._reference, *speeds)}"


class Orbit:
    """Inset with the orbit of the shaft over some records, emphasised up to the picture's time."""

    def __init__(self, scene: StageScene, dataset: xr.Dataset, records: IntArray) -> None:
        drawing = scene.drawing
        self._time = dataset["time"].values[records]
        places, title = look.shaft_trail(dataset, records, drawing.frame)
        write(scene.plotter, title, TOPS["orbit"], 13)
        width, height = scene.plotter.window_size
        low = scene.place(look.SQUARE + 0.02, TOPS["orbit"] - 0.045 - ORBIT_SIZE)
        high = scene.place(look.SQUARE + 0.02 + ORBIT_SIZE * height / width, TOPS["orbit"] - 0.045)
        self._middle, half = (low + high) / 2, (high[1] - low[1]) / 2
        self._way = self._middle + half * places
        circle = self._middle + half * directions(np.linspace(0.0, 2 * np.pi, 73))
        across = np.array([[-half, 0.0], [half, 0.0], [0.0, 0.0], [0.0, -half], [0.0, half]])
        for line in (circle, self._middle + across):
            add_line(scene.plotter, line, look.NO_VALUE, 1.5)
        add_line(scene.plotter, self._way, look.FAINT, 1.0)
        self._trail = add_line(scene.plotter, self._way, look.FORCE_COLOUR, 2.5)
        self._disc = 0.05 * half * CIRCLE
        self._dot = pyvista.PolyData.from_regular_faces(
            np.pad(self._middle + self._disc, ON_PLANE), disc_triangles(1)
        )
        scene.plotter.add_mesh(self._dot, color=look.INK, lighting=False)

    def show(self, time: float) -> None:
        """Emphasise the orbit up to a time [s]."""
        past = int(np.searchsorted(self._time, time, side="right"))
        seen = self._way.copy()
        seen[past:] = self._way[past - 1]
        self._trail.points[:, :2] = seen
        self._dot.points[:, :2] = self._way[past - 1] + self._disc


class TimeLine:
    """Contact force of all blades at the times of a film, with marks at the picture's time and at
    the `loss` of a blade [s]."""

    def __init__(self, scene: StageScene, loss: float | None) -> None:
        drawing, (left, right, low, high) = scene.drawing, LINE
        force, times = drawing.total_force, drawing.times
        share = (times - times[0]) / np.ptp(times)
        corners = scene.place(left, low), scene.place(right, high)
        (self._start, foot), (end, top) = corners
        self._times, self._length = times[[0, -1]], end - self._start
        across = self._start + self._length * share
        up = foot + (top - foot) * force / (force.max() or 1.0)
        add_line(scene.plotter, np.array([[self._start, foot], [end, foot]]), look.FAINT, 1.0)
        if force.any():
            add_line(scene.plotter, np.column_stack([across, up]), look.FORCE_COLOUR, 1.5)
        ends = np.array([[self._start, foot], [self._start, top]])
        self._mark = add_line(scene.plotter, ends, look.INK, 3.0)
        if loss is not None and times[0] <= loss <= times[-1]:
            at = self._length * (loss - times[0]) / np.ptp(times)
            add_line(scene.plotter, ends + np.array([at, 0.0]), look.FORCE_COLOUR, 3.0)
        text = f"{1e3 * times[0]:.4g} to {1e3 * times[-1]:.4g} ms"
        if force.any():
            text = f"total force, up to {handy(float(force.max()), 'N', 3)}\n{text}"
        write(scene.plotter, text, LINE_TOP, 10, color=look.FAINT)

    def show(self, time: float) -> None:
        """Move the mark to a time [s]."""
        share = (time - self._times[0]) / np.ptp(self._times)
        self._mark.points[:, 0] = self._start + self._length * share


def add_line(plotter: pyvista.Plotter, line: Array, colour: str, width: float) -> pyvista.PolyData:
    """Add a line of points (point, 2) in the drawing plane, with a width [pixels of a window that
    is 960 pixels high]."""
    points = np.pad(line if len(line) > 1 else np.repeat(line, 2, axis=0), ON_PLANE)
    mesh = pyvista.PolyData(points, lines=[len(points), *range(len(points))])
    width *= plotter.window_size[1] / 960
    plotter.add_mesh(mesh, color=colour, line_width=width, lighting=False)
    return mesh


class BladeNumbers:
    """Numbers next to several blades; with many blades only every second, fifth or tenth number.

    Args:
        scene: the stage.
        first: number of the first contact node of each blade, (blades,).
        letters: size of the numbers, relative to that in a single picture.
    """

    def __init__(self, scene: StageScene, first: IntArray, letters: float = 1.0) -> None:
        steps = (1, 2, 5, 10, 20, 50, 100, 200, 500)
        stride = next(step for step in steps if letters * len(first) <= 25 * step)
        blades = np.arange(0, len(first), stride) if len(first) > 1 else np.zeros(0, np.int64)
        self._first, self._size, self._blades = first, scene.size, blades
        self._corner, far = scene.place(0.0, 0.0), scene.place(1.0, 1.0)
        self._pixels = np.array(scene.plotter.window_size) / (far - self._corner)
        self._actors = [
            write(scene.plotter, str(blade), 0.0, 10 * letters, indent=float(blade))
            for blade in blades
        ]
        for actor in self._actors:
            actor.prop.SetJustificationToCentered()
            actor.prop.SetVerticalJustificationToCentered()
            actor.prop.SetBackgroundColor(1.0, 1.0, 1.0)
            actor.prop.SetBackgroundOpacity(0.8)

    def show(self, picture: Picture) -> None:
        """Move the numbers to their blades."""
        beside = number_places(picture, self._first, self._size)[self._blades]
        for actor, place in zip(self._actors, self._pixels * (beside - self._corner), strict=True):
            seen = bool(np.isfinite(place).all())
            actor.SetVisibility(seen)
            if seen:
                actor.SetPosition(*place)


def draw_scale_bar(scene: StageScene, enlarged: str) -> str:
    """Draw a scale bar in the lower left corner; return its text: the length of the bar, and the
    true size of the `enlarged` quantities that are drawn as long as the bar."""
    (left, foot), (right, _) = scene.place(0.02, 0.03), scene.place(0.02 + BAR_SHARE, 0.03)
    length = rounded_down(right - left)
    start, end, up = np.array([left, foot]), np.array([left + length, foot]), np.array([0, 0.05])
    ticks = [[at - length * up, at + length * up] for at in (start, end)]
    scene.symbols(Symbols(springs=np.array([[start, end], *ticks])))
    drawing = scene.drawing
    return look.bar_text(length, enlarged, drawing.exaggeration, scene.metres_per_newton)


def write_bar(scene: StageScene, text: str) -> None:
    """Write the text of the scale bar above it."""
    top = BAR_FOOT + BAR_STEP * len(text.splitlines())
    write(scene.plotter, text, top, 11, indent=-look.SQUARE)


def write_title(plotter: pyvista.Plotter, dataset: xr.Dataset) -> None:
    """Write the title of the case at the top of the panel."""
    title = textwrap.fill(str(dataset.attrs["title"]), TITLE_LETTERS, max_lines=2)
    write(plotter, title, TOPS["title"], 16)


def write_scales(scene: StageScene, top: float) -> None:
    """Draw the colour scales of blades and wall side by side below `top`."""
    write(scene.plotter, scene.drawing.colouring.name, top, 13)
    for number, (label, scale) in enumerate(scene.drawing.colouring.scales.items()):
        aside = SCALE_ASIDE * number
        write(scene.plotter, label, top - KEY_STEP, 11, indent=aside)
        left, end = look.SQUARE + 0.02 + aside, top - 0.075
        low, high = scene.place(left, SCALE_FOOT), scene.place(left + SCALE_WIDTH, end)
        scene.bar(low, high, scale)
        (west, south), (east, north) = low, high
        edge = [[west, south], [east, south], [east, north], [west, north], [west, south]]
        add_line(scene.plotter, np.array(edge), look.FAINT, 1.0)
        for share in np.linspace(0.0, 1.0, TICKS[end - SCALE_FOOT < SHORT]):
            first, last = scale.limits
            tick, place = first + share * (last - first), SCALE_FOOT + share * (end - SCALE_FOOT)
            write(scene.plotter, f"{tick:.3g}", place + 0.007, 11, indent=aside + 0.025)


def write_key(
    plotter: pyvista.Plotter,
    colours: Mapping[str, str],
    top: float,
    *,
    sign: str = "\N{BLACK SQUARE}",
) -> None:
    """Write a key below `top`: `sign` in each colour, with its name."""
    for number, (name, colour) in enumerate(colours.items()):
        height = top - KEY_STEP * number
        write(plotter, sign, height, 19, color=look.INK, indent=-0.0012)
        write(plotter, sign, height - 0.0015, 16, color=colour)
        short = name[: KEY_LETTERS - 1] + "\N{HORIZONTAL ELLIPSIS}"
        text = name if len(name) <= KEY_LETTERS else short
        write(plotter, text, height - 0.005, 13, indent=0.025)


def write_symbols(scene: StageScene, top: float) -> int:
    """Write a key of the drawn kinds of symbols below `top`; return the number of kinds."""
    drawn = scene.drawing.picture(0).symbols
    kinds = [kind for kind in KINDS if len(getattr(drawn, kind))]
    for number, kind in enumerate(kinds):
        height = top - KEY_STEP * number - 0.012
        start, end = (scene.place(look.SQUARE + across, height) for across in (0.018, 0.06))
        scene.symbols(sample(kind, start, end))
        write(scene.plotter, KINDS[kind], height + 0.007, 13, indent=0.052)
    return len(kinds)


def write(
    plotter: pyvista.Plotter,
    text: str,
    top: float,
    size: float,
    *,
    color: str = look.INK,
    indent: float = 0.0,
) -> pyvista.Text:
    """Write text into the panel.

    Args:
        plotter: plotter with the panel.
        text: the text.
        top: upper edge of the text, relative to the height of the window.
        size: font size in a window that is 960 pixels high.
        color: colour of the text.
        indent: distance from the left edge of the panel, relative to the width of the window.
    """
    width, height = plotter.window_size
    actor: pyvista.Text = plotter.add_text(
        text,
        position=(round((look.SQUARE + 0.02 + indent) * width), round(top * height)),
        font_size=look.FINER * round(0.7 * size * height / 960 / look.FINER),
        color=color,
        font_file=look.FONT,
        name=f"panel at {top}, {indent}",
    )
    actor.prop.SetVerticalJustificationToTop()
    actor.prop.SetLineSpacing(1.25)
    return actor
