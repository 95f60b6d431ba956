"""A small WebGL viewer inside a page: the packed triangles, and the script that turns them under the mouse.

The page needs nothing from outside. Positions are 16-bit fractions of the bounding box (about 20 µm for an
arm), normals and colours one byte a component; the whole is deflated and written in base64.
"""

from __future__ import annotations

import base64
import html
import json
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from burnish.analysis.render import Camera
from burnish.analysis.shape import Shape
from burnish.core import Array

STEPS = 65535
"""Largest packed coordinate."""
VERTEX = np.dtype([("position", "<u2", 4), ("normal", "i1", 4), ("colour", "u1", 4)])
"""One packed corner; the fourth component of the colour is the gloss, the others pad to whole words."""


@dataclass(frozen=True, kw_only=True)
class Packed:
    """Triangles as the viewer reads them."""

    header: dict[str, object]
    """Sizes, bounding box and groups, ready for JSON."""
    data: bytes
    """Vertices and indices, deflated."""


def pack(shapes: Sequence[Shape]) -> Packed:
    """The triangles of all shapes; shapes of one name become one group that is switched as a whole."""
    low = np.min([shape.corners.min(axis=(0, 1)) for shape in shapes], axis=0)
    high = np.max([shape.corners.max(axis=(0, 1)) for shape in shapes], axis=0)
    names = list(dict.fromkeys(shape.name for shape in shapes))
    ordered = sorted(shapes, key=lambda shape: names.index(shape.name))
    corners = np.concatenate([_packed_corners(shape, low, np.maximum(high - low, 1e-9)) for shape in ordered])
    # Equal corners are stored once; a void view makes them comparable as a whole.
    vertices, indices = np.unique(corners.view(f"V{VERTEX.itemsize}"), return_inverse=True)
    groups: list[dict[str, object]] = []
    start = 0
    for name in names:
        members = [shape for shape in ordered if shape.name == name]
        count = 3 * sum(len(shape.faces) for shape in members)
        colour = (255.0 * np.atleast_2d(members[0].colour).mean(axis=0)).round().astype(int).tolist()
        groups.append({"name": name, "colour": colour, "start": start, "count": count})
        start += count
    header: dict[str, object] = {
        "vertices": len(vertices),
        "low": low.tolist(),
        "size": np.maximum(high - low, 1e-9).tolist(),
        "groups": groups,
    }
    data = vertices.tobytes() + indices.astype("<u4").tobytes()
    return Packed(header=header, data=zlib.compress(data, 9))


def viewer_html(packed: Packed, camera: Camera) -> str:
    """A ``<div>`` with the viewer; it fills the width, and says so where the browser has no WebGL."""
    view = {
        "eye": camera.eye.tolist(),
        "target": camera.target.tolist(),
        "slope": float(np.tan(np.radians(camera.field_of_view_deg) / 2.0)),
    }
    # "<" is the only character that could end the element early.
    header = json.dumps({**packed.header, **view}).replace("<", "\\u003c")
    data = base64.b64encode(packed.data).decode("ascii")
    title = html.escape("The scene in three dimensions")
    return (
        f'<div class="scene"><canvas tabindex="0" role="img" aria-label="{title}"></canvas>'
        '<div class="legend"></div>'
        '<p class="hint">Drag to turn, shift-drag or right-drag to move, click and scroll to zoom, '
        "double-click to come back. The names switch parts on and off.</p>"
        '<p class="without">This browser cannot show WebGL; the picture at the top shows the same scene.</p>'
        f'<script type="application/json">{header}</script>'
        f'<script type="text/plain">{data}</script>'
        f"<style>{STYLE}</style><script>{SCRIPT}</script></div>"
    )


def _packed_corners(shape: Shape, low: Array, size: Array) -> np.ndarray[tuple[int], np.dtype[np.void]]:
    packed = np.zeros(3 * len(shape.faces), dtype=VERTEX)
    packed["position"][:, :3] = ((shape.corners.reshape(-1, 3) - low) / size * STEPS).round()
    packed["normal"][:, :3] = (127.0 * shape.corner_normals.reshape(-1, 3)).round()
    packed["colour"][:, :3] = (255.0 * shape.corner_colours.reshape(-1, 3)).round()
    packed["colour"][:, 3] = round(255.0 * shape.gloss)
    return packed


STYLE = """
.scene{position:relative}
.scene canvas{display:block;width:100%;aspect-ratio:16/10;max-height:80vh;border-radius:6px;touch-action:none;
cursor:grab;outline-offset:2px;background:linear-gradient(#f8fafb,#e2e4e7)}
.scene .legend{display:flex;flex-wrap:wrap;gap:.4rem;margin:.6rem 0 0}
.scene .legend button{display:flex;align-items:center;gap:.4rem;font:inherit;font-size:.85rem;color:inherit;
background:#fff;border:1px solid #cfd4da;border-radius:999px;padding:.15rem .7rem;cursor:pointer}
.scene .legend button[aria-pressed=false]{opacity:.45;text-decoration:line-through}
.scene .legend i{width:.8em;height:.8em;border-radius:50%;border:1px solid #0003}
.scene .without,.scene.flat canvas,.scene.flat .hint,.scene.flat .legend{display:none}
.scene.flat .without{display:block}
@media print{.scene{display:none}}
"""

SCRIPT = """
(async () => {
const root = document.currentScript.parentElement, canvas = root.querySelector('canvas');
const scene = JSON.parse(root.querySelector('script[type="application/json"]').textContent);
const gl = canvas.getContext('webgl2', {antialias: true});
if (!gl || !window.DecompressionStream) { root.classList.add('flat'); return; }
const text = root.querySelector('script[type="text/plain"]').textContent;
const deflated = Uint8Array.from(atob(text), c => c.charCodeAt(0));
const inflated = new Blob([deflated]).stream().pipeThrough(new DecompressionStream('deflate'));
const data = await new Response(inflated).arrayBuffer();

const compile = (type, source) => {
  const shader = gl.createShader(type);
  gl.shaderSource(shader, '#version 300 es\\nprecision highp float;' + source);
  gl.compileShader(shader);
  return shader;
};
const program = gl.createProgram();
gl.attachShader(program, compile(gl.VERTEX_SHADER, `
  uniform vec3 low, size, eye, right, up, forward; uniform vec4 lens;
  in vec4 position, normal, colour; out vec3 point, n; out vec4 paint;
  void main() {
    point = low + size * position.xyz; n = normal.xyz; paint = colour;
    vec3 d = point - eye; float depth = dot(d, forward);
    gl_Position = vec4(dot(d, right) * lens.x, dot(d, up) * lens.y,
      (depth * (lens.w + lens.z) - 2. * lens.w * lens.z) / (lens.w - lens.z), depth);
  }`));
gl.attachShader(program, compile(gl.FRAGMENT_SHADER, `
  uniform vec3 eye, key; in vec3 point, n; in vec4 paint; out vec4 light;
  void main() {
    vec3 view = normalize(eye - point), m = normalize(n);
    if (dot(m, view) < 0.) m = -m;
    float lit = max(dot(m, key), 0.), fill = max(dot(m, -key * vec3(1., 1., -.3)), 0.);
    float shine = .55 * pow(max(dot(m, normalize(view + key)), 0.), 48.) + .16 * pow(1. - dot(m, view), 3.);
    vec3 sum = pow(paint.rgb, vec3(2.2)) * (.72 * lit + .35 * fill + .26 + .26 * (.5 + .5 * m.z)) + paint.a * shine;
    light = vec4(pow(sum, vec3(1. / 2.2)), 1.);
  }`));
gl.linkProgram(program); gl.useProgram(program); gl.enable(gl.DEPTH_TEST);

const stride = 16, bytes = scene.vertices * stride;
gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
gl.bufferData(gl.ARRAY_BUFFER, new Uint8Array(data, 0, bytes), gl.STATIC_DRAW);
gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint8Array(data, bytes), gl.STATIC_DRAW);
[['position', gl.UNSIGNED_SHORT, 0], ['normal', gl.BYTE, 8], ['colour', gl.UNSIGNED_BYTE, 12]].forEach(
  ([name, type, offset]) => {
    const place = gl.getAttribLocation(program, name);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 4, type, true, stride, offset);
  });
const uniform = (name, ...values) =>
  gl['uniform' + values.length + 'f'](gl.getUniformLocation(program, name), ...values);
uniform('low', ...scene.low); uniform('size', ...scene.size);

const span = Math.hypot(...scene.size);
const back = scene.eye.map((x, i) => x - scene.target[i]);
const start = {target: scene.target, distance: Math.hypot(...back), azimuth: Math.atan2(back[1], back[0]),
  elevation: Math.atan2(back[2], Math.hypot(back[0], back[1]))};
let pose = {...start}, waiting = false;
const cross = (a, b) => [a[1]*b[2] - a[2]*b[1], a[2]*b[0] - a[0]*b[2], a[0]*b[1] - a[1]*b[0]];
const axes = () => {
  const c = Math.cos(pose.elevation), s = Math.sin(pose.elevation);
  const forward = [-c * Math.cos(pose.azimuth), -c * Math.sin(pose.azimuth), -s];
  const right = [-Math.sin(pose.azimuth), Math.cos(pose.azimuth), 0];
  return {right, forward, up: cross(right, forward)};
};
const draw = () => {
  waiting = false;
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  canvas.width = canvas.clientWidth * ratio; canvas.height = canvas.clientHeight * ratio;
  gl.viewport(0, 0, canvas.width, canvas.height);
  const {right, forward, up} = axes(), eye = pose.target.map((x, i) => x - pose.distance * forward[i]);
  const near = Math.max(pose.distance - 1.5 * span, .02 * pose.distance);
  uniform('eye', ...eye); uniform('right', ...right); uniform('up', ...up); uniform('forward', ...forward);
  uniform('lens', canvas.height / canvas.width / scene.slope, 1 / scene.slope, near, pose.distance + 1.5 * span);
  const key = right.map((x, i) => -.75 * x - (i < 2 ? .45 * forward[i] : -1.15));
  uniform('key', ...key.map(x => x / Math.hypot(...key)));
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  scene.groups.filter(g => !g.hidden).forEach(
    g => gl.drawElements(gl.TRIANGLES, g.count, gl.UNSIGNED_INT, 4 * g.start));
};
const redraw = () => { if (!waiting) { waiting = true; requestAnimationFrame(draw); } };
const turn = (dx, dy) => {
  pose.azimuth -= .008 * dx;
  pose.elevation = Math.min(1.55, Math.max(-1.55, pose.elevation + .008 * dy));
};
const move = (dx, dy) => {
  const step = 2 * scene.slope * pose.distance / canvas.clientHeight, {right, up} = axes();
  pose.target = pose.target.map((x, i) => x + step * (dy * up[i] - dx * right[i]));
};
const zoom = factor => {
  pose.distance = Math.min(5 * start.distance, Math.max(.03 * span, pose.distance * factor));
};

const fingers = new Map();
canvas.addEventListener('pointerdown', e => { canvas.setPointerCapture(e.pointerId); fingers.set(e.pointerId, e); });
['pointerup', 'pointercancel'].forEach(name => canvas.addEventListener(name, e => fingers.delete(e.pointerId)));
canvas.addEventListener('pointermove', e => {
  const old = fingers.get(e.pointerId);
  if (!old) return;
  const dx = e.clientX - old.clientX, dy = e.clientY - old.clientY;
  const other = [...fingers.values()].find(f => f.pointerId !== e.pointerId);
  if (other) {
    const gap = f => Math.hypot(f.clientX - other.clientX, f.clientY - other.clientY);
    zoom(gap(old) / Math.max(gap(e), 1)); move(dx / 2, dy / 2);
  } else if (e.shiftKey || e.buttons & 6) move(dx, dy); else turn(dx, dy);
  fingers.set(e.pointerId, e); redraw();
});
canvas.addEventListener('wheel', e => {
  if (document.activeElement !== canvas && !e.ctrlKey) return;
  e.preventDefault();
  const before = pose.distance, place = canvas.getBoundingClientRect();
  zoom(Math.exp(.001 * e.deltaY));
  // What is under the pointer stays there.
  const gain = 1 - before / pose.distance;
  move(gain * (e.clientX - place.left - place.width / 2), gain * (e.clientY - place.top - place.height / 2));
  redraw();
}, {passive: false});
canvas.addEventListener('contextmenu', e => e.preventDefault());
canvas.addEventListener('dblclick', () => { pose = {...start}; redraw(); });
canvas.addEventListener('keydown', e => {
  const act = {ArrowLeft: () => turn(-12, 0), ArrowRight: () => turn(12, 0), ArrowUp: () => turn(0, -12),
    ArrowDown: () => turn(0, 12), '+': () => zoom(.9), '-': () => zoom(1 / .9)}[e.key];
  if (act) { e.preventDefault(); act(); redraw(); }
});
scene.groups.forEach(group => {
  const button = root.querySelector('.legend').appendChild(document.createElement('button'));
  button.appendChild(document.createElement('i')).style.background = `rgb(${group.colour})`;
  button.append(group.name); button.setAttribute('aria-pressed', true);
  button.addEventListener('click', () => {
    group.hidden = !group.hidden; button.setAttribute('aria-pressed', !group.hidden); redraw();
  });
});
new ResizeObserver(redraw).observe(canvas);
})();
"""
