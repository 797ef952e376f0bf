"""Membranes to be turned and run in time (figure 3.10), as one page with its script inside and nothing fetched."""

from __future__ import annotations

import json
from collections.abc import Mapping

import numpy as np

from ipcli.report.kit.numbers import number
from ipcli.report.kit.page import element
from ipcli.report.kit.style import CSS

SCRIPT = """
const data = JSON.parse(document.getElementById('data').textContent);
let turn = 0.6, tilt = 1.05, moment = 0, playing = true;
const slider = document.getElementById('time'), told = document.getElementById('told');
slider.max = data.times.length - 1;
function colour(v) {
  const s = Math.max(-1, Math.min(1, v)), t = Math.abs(s), a = s > 0 ? [178, 24, 43] : [33, 102, 172];
  return `rgb(${a.map(c => Math.round(235 + (c - 235) * t)).join(',')})`;
}
function draw(canvas, shape) {
  const g = canvas.getContext('2d'), w = canvas.width, h = canvas.height, n = data.angles, rings = data.rings;
  const u = shape[moment], size = 0.42 * w, quads = [];
  const at = (i, k) => {
    const r = i / (rings - 1), a = 2 * Math.PI * (k % n) / n, z = u[i * n + k % n];
    const x = r * Math.cos(a + turn), y = r * Math.sin(a + turn);
    return [w / 2 + size * x, h / 2 + size * (y * Math.cos(tilt) - 0.45 * z * Math.sin(tilt)), y, z];
  };
  for (let i = 0; i + 1 < rings; i++) for (let k = 0; k < n; k++) {
    const q = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
    quads.push([q.reduce((s, p) => s + p[2], 0), q, q.reduce((s, p) => s + p[3], 0) / 4]);
  }
  quads.sort((a, b) => a[0] - b[0]);
  g.clearRect(0, 0, w, h);
  g.strokeStyle = 'rgba(60,60,60,0.35)';
  for (const [, q, mean] of quads) {
    g.fillStyle = colour(mean);
    g.beginPath();
    q.forEach((p, i) => i ? g.lineTo(p[0], p[1]) : g.moveTo(p[0], p[1]));
    g.closePath(); g.fill(); g.stroke();
  }
}
const canvases = [...document.querySelectorAll('canvas')];
function show() {
  told.textContent = `${(1000 * data.times[moment]).toFixed(0)} ms`;
  slider.value = moment;
  canvases.forEach((canvas, n) => draw(canvas, data.shapes[n]));
}
canvases.forEach(canvas => canvas.addEventListener('pointermove', event => {
  if (!event.buttons) return;
  turn += event.movementX / 90; tilt = Math.max(0.1, Math.min(1.5, tilt + event.movementY / 120)); show();
}));
slider.addEventListener('input', () => { playing = false; moment = +slider.value; show(); });
document.getElementById('play').addEventListener('click', () => { playing = !playing; });
setInterval(() => { if (playing) { moment = (moment + 1) % data.times.length; show(); } }, 90);
show();
"""


def turnable(a: Mapping[str, np.ndarray]) -> str:
    """The page of the membranes that an artefact keeps: drag to turn, a slider and a button for time."""
    shapes = a["membranes/shapes"]
    count, moments, rings, angles = shapes.shape
    top = np.maximum(np.abs(shapes).max(axis=(1, 2, 3), keepdims=True), 1e-12)
    data = {
        "times": np.round(a["membranes/times"], 4).tolist(),
        "rings": rings,
        "angles": angles,
        "shapes": np.round(shapes / top, 3).reshape(count, moments, rings * angles).tolist(),
    }
    figures = [
        element(
            "figure",
            element("canvas", width=380, height=300, style="max-width:100%;touch-action:none"),
            element("figcaption", element("b", f"Membrane {n + 1}"), element("span", _words(a, n))),
        )
        for n in range(count)
    ]
    title = "Membranes at the strongest proto-objects"
    lead = (
        "Drag to turn. Each is drawn to the height of its own greatest displacement; red is up, blue down. A membrane "
        "is struck the harder the greater σ, the curvature or the learnt saliency of its place; z is the distance of "
        "the place over the median of all, a the membrane's radius."
    )
    # inside a script element only "</" ends it, and "<" is nowhere in numbers
    script = json.dumps(data, separators=(",", ":"))
    controls = (
        "<p><button id='play'>play or stop</button> <input id='time' type='range' min='0' value='0'> "
        "<span id='told'></span></p>"
    )
    body = f"<h1>{title}</h1><p class='lead'>{lead}</p>{controls}<div class='gallery' style='--columns:3'>"
    return (
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>"
        "<meta http-equiv='Content-Security-Policy' content=\"default-src 'none'; style-src 'unsafe-inline'; "
        "script-src 'unsafe-inline'\">"
        f"<meta name='viewport' content='width=device-width, initial-scale=1'><title>{title}</title>"
        f"<style>{CSS}</style>"
        f"</head><body><main>{body}{''.join(figures)}</div></main>"
        f"<script type='application/json' id='data'>{script}</script><script>{SCRIPT}</script></body></html>\n"
    )


def _words(a: Mapping[str, np.ndarray], n: int) -> str:
    sigma, z, radius = (number(float(value)) for value in a["membranes/parameters"][n])
    return f"σ = {sigma}, z = {z}, a = {radius}"
