"use strict";
// Values under the pointer, see hover.py: every <img data-hover="ID"> has its data in a script of that id.
const NEAR = 14; // distance from a drawn point at which it is named [pixels]
const tip = document.body.appendChild(document.createElement("div"));
tip.id = "hover-tip";
tip.style.cssText = "position: fixed; display: none; pointer-events: none; white-space: pre; z-index: 9;"
  + "background: #1c2330; color: white; font: 13px/1.35 sans-serif; padding: 5px 9px; border-radius: 5px";
const digits = value => Number(value.toPrecision(4)).toString();
const valueAt = (axis, share) => {
  const [low, high] = axis.ends;
  return axis.log ? low * (high / low) ** share : low + (high - low) * share;
};
const cellOf = (edges, at) => {
  for (let i = 0; i + 1 < edges.length; i++)
    if ((at - edges[i]) * (at - edges[i + 1]) <= 0) return i;
  return edges.length ? edges.length - 1 : -1;
};
for (const picture of document.querySelectorAll("img[data-hover]")) {
  const panels = JSON.parse(document.getElementById(picture.dataset.hover).textContent);
  picture.addEventListener("pointermove", event => {
    const seen = picture.getBoundingClientRect(), FULL = 10000;
    const x = (event.clientX - seen.left) / seen.width * FULL;
    const y = (event.clientY - seen.top) / seen.height * FULL;
    const panel = panels.find(({ box: [l, t, r, b] }) => l <= x && x <= r && t <= y && y <= b);
    let lines = [];
    if (panel) {
      let [px, py, name, best] = [x, y, "", NEAR];
      for (const curve of panel.curves) for (const [cx, cy] of curve.points) {
        const far = Math.hypot((cx - x) * seen.width, (cy - y) * seen.height) / FULL;
        if (far < best) [px, py, name, best] = [cx, cy, curve.name, far];
      }
      const [l, t, r, b] = panel.box;
      if (best < NEAR || panel.maps.length) lines = [
        name,
        `${panel.x.label}: ${digits(valueAt(panel.x, (px - l) / (r - l)))}`,
        `${panel.y.label}: ${digits(valueAt(panel.y, (b - py) / (b - t)))}`];
      for (const map of panel.maps) {
        const value = map.values[cellOf(map.y, y)]?.[cellOf(map.x, x)];
        if (value != null) lines.push((map.label ? `${map.label}: ` : "") + digits(value));
      }
    }
    tip.style.display = lines.length ? "block" : "none";
    tip.textContent = lines.filter(line => line).join("\n");
    tip.style.left = `${Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 8)}px`;
    tip.style.top = `${Math.min(event.clientY + 14, innerHeight - tip.offsetHeight - 8)}px`;
  });
  picture.addEventListener("click", event => { // on a map of points that have pages
    const seen = picture.getBoundingClientRect();
    const [x, y] = [(event.clientX - seen.left) / seen.width * 10000, (event.clientY - seen.top) / seen.height * 10000];
    const panel = panels.find(({ box: [l, t, r, b], links }) => links && l <= x && x <= r && t <= y && y <= b);
    const [map] = panel ? panel.maps.slice(-1) : [];
    const link = map && panel.links[cellOf(map.y, y)]?.[cellOf(map.x, x)];
    if (link) location.href = link;
  });
  picture.addEventListener("pointerleave", () => { tip.style.display = "none"; });
}
