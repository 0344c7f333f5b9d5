"""Renders the solids' own surfaces to PNG without a display: a small z-buffer in numpy over OCC's exact points, normals and curvatures.

For each body two pictures in docs/pictures/: NAME.png, shaded, with the borders of the faces; NAME-curvature.png, coloured by the mean
curvature times the strut's radius (0.5 on a strut; the crotches below 0).
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepTools import BRepTools
from OCP.gp import gp_Pnt, gp_Vec
from PIL import Image, ImageDraw, ImageFont

import cases
import program
from model import Model

FOLDER = program.ROOT / "docs" / "pictures"
WIDTH, SUPER = 900, 2  # pixels, and how many of ours make one along each axis
CURVATURE_RANGE = (-1.0, 1.0)  # of mean curvature times radius
STEEL = np.array([0.66, 0.72, 0.80])


# --- surfaces to triangles --------------------------------------------------------------------------------------------------------


def grid(face, steps_u: int, steps_v: int):
    """Points, outward normals and mean curvature (positive where the solid bulges) on a face that fills its parameter rectangle."""
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face.face)
    p, du, dv, duu, dvv, duv = gp_Pnt(), gp_Vec(), gp_Vec(), gp_Vec(), gp_Vec(), gp_Vec()
    points, normals, means = [], [], []
    for i in range(steps_u + 1):
        for j in range(steps_v + 1):
            face.surface.D2(u0 + (u1 - u0) * i / steps_u, v0 + (v1 - v0) * j / steps_v, p, du, dv, duu, dvv, duv)
            n = du.Crossed(dv)
            size = max(n.Magnitude(), 1e-300)
            e, f, g = du.Dot(du), du.Dot(dv), dv.Dot(dv)
            l, m, k = duu.Dot(n) / size, duv.Dot(n) / size, dvv.Dot(n) / size
            points.append((p.X(), p.Y(), p.Z()))
            normals.append((n.X() / size, n.Y() / size, n.Z() / size))
            means.append(-(e * k - 2 * f * m + g * l) / (2 * max(e * g - f * f, 1e-300)))
    index = np.arange((steps_u + 1) * (steps_v + 1)).reshape(steps_u + 1, steps_v + 1)
    a, b, c, d = index[:-1, :-1].ravel(), index[1:, :-1].ravel(), index[1:, 1:].ravel(), index[:-1, 1:].ravel()
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return np.array(points), face.sign * np.array(normals), face.sign * np.array(means), triangles


def disc(face, model: Model):
    """A flat cap: a fan over its rim."""
    rim = [point for use in model.edges for f, e in use.uses if f is face for point in line(e, 48)[:-1]]
    centre = np.mean(rim, axis=0)
    p, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    face.surface.D1(0, 0, p, du, dv)
    n = du.Crossed(dv)
    normal = face.sign * np.array([n.X(), n.Y(), n.Z()]) / n.Magnitude()
    around = np.arange(len(rim))
    points = np.vstack([rim, centre])
    return points, np.tile(normal, (len(points), 1)), np.zeros(len(points)), np.stack(
        [around, np.roll(around, -1), np.full(len(rim), len(rim))], 1)


def line(edge, steps: int) -> np.ndarray:
    curve = BRepAdaptor_Curve(edge)
    ts = np.linspace(curve.FirstParameter(), curve.LastParameter(), steps + 1)
    return np.array([(p.X(), p.Y(), p.Z()) for p in map(curve.Value, ts)])


def mesh(model: Model, fineness: int):
    parts, offset, out = [], 0, []
    for face in model.faces:
        if face.kind == "plane":
            part = disc(face, model)
        elif face.kind in ("cylinder", "cone"):
            part = grid(face, 6 * fineness, 2)
        else:
            part = grid(face, fineness, fineness)
        parts.append(part)
        out.append(part[3] + offset)
        offset += len(part[0])
    return (*(np.concatenate([p[i] for p in parts]) for i in range(3)), np.concatenate(out))


def borders(model: Model) -> list[np.ndarray]:
    """Polylines of all edges but the seams."""
    return [line(use.edge, 48) for use in model.edges if len({f.index for f, _ in use.uses}) > 1 and not use.degenerate]


# --- triangles to pixels ----------------------------------------------------------------------------------------------------------


def look(points: np.ndarray, view: tuple[float, float], size: int):
    """A function from the world to pixels and depth (larger is nearer), and the viewing axes. Parallel projection."""
    azimuth, height = np.radians(view)
    towards = np.array([np.cos(height) * np.cos(azimuth), np.cos(height) * np.sin(azimuth), np.sin(height)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    axes = np.stack([right, np.cross(towards, right), towards])
    seen = points @ axes.T
    low, high = seen[:, :2].min(0), seen[:, :2].max(0)
    scale = 0.94 * size / max(high - low)
    middle = (low + high) / 2

    def project(p: np.ndarray) -> np.ndarray:
        q = p @ axes.T
        return np.column_stack([(q[:, 0] - middle[0]) * scale + size / 2, size / 2 - (q[:, 1] - middle[1]) * scale, q[:, 2] * scale])

    return project, axes


def rasterize(screen: np.ndarray, triangles: np.ndarray, size: int):
    """Which triangle each pixel shows, with its barycentric coordinates and depth."""
    depth = np.full((size, size), -np.inf)
    owner = np.full((size, size), -1, np.int32)
    weights = np.zeros((size, size, 3), np.float32)
    corners = screen[triangles]
    low = np.clip(np.floor(corners[:, :, :2].min(1)).astype(int), 0, size - 1)
    high = np.clip(np.ceil(corners[:, :, :2].max(1)).astype(int) + 1, 0, size)
    edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = edge1[:, 0] * edge2[:, 1] - edge1[:, 1] * edge2[:, 0]
    for t in np.flatnonzero(np.abs(area) > 1e-9):
        (x0, y0), (x1, y1) = low[t], high[t]
        a, e1, e2 = corners[t, 0], edge1[t], edge2[t]
        dx, dy = np.arange(x0, x1)[None, :] + 0.5 - a[0], np.arange(y0, y1)[:, None] + 0.5 - a[1]
        v = (dx * e2[1] - dy * e2[0]) / area[t]
        w = (dy * e1[0] - dx * e1[1]) / area[t]
        z = a[2] + v * e1[2] + w * e2[2]
        block = depth[y0:y1, x0:x1]
        hit = (v >= -1e-6) & (w >= -1e-6) & (v + w <= 1 + 1e-6) & (z > block)
        if hit.any():
            block[hit] = z[hit]
            owner[y0:y1, x0:x1][hit] = t
            weights[y0:y1, x0:x1][hit] = np.stack([1 - v - w, v, w], -1)[hit]
    return depth, owner, weights


def interpolate(values: np.ndarray, triangles, owner, weights) -> np.ndarray:
    corner = values[triangles[np.maximum(owner, 0)]]
    return np.einsum("ijk...,ijk->ij...", corner, weights)


def shade(normals: np.ndarray, axes: np.ndarray, colour: np.ndarray, ambient: float) -> np.ndarray:
    seen = normals @ axes.T
    seen /= np.maximum(np.linalg.norm(seen, axis=-1, keepdims=True), 1e-12)
    key, fill = np.array([-0.45, 0.65, 0.62]), np.array([0.7, -0.1, 0.5])
    key, fill = key / np.linalg.norm(key), fill / np.linalg.norm(fill)
    half = key + np.array([0, 0, 1])
    half /= np.linalg.norm(half)
    light = ambient + (1.02 - ambient) * (0.75 * np.clip(seen @ key, 0, 1) + 0.30 * np.clip(seen @ fill, 0, 1))
    shine = 0.25 * np.clip(seen @ half, 0, 1) ** 60
    return np.clip(colour * light[..., None] + shine[..., None], 0, 1)


def ramp(values: np.ndarray, span: tuple[float, float]) -> np.ndarray:
    """Blue below 0, pale at 0, red above; full at the ends of the span, which may begin at 0."""
    low, high = span
    t = np.clip(np.where(values < 0, values / (-low or 1.0), values / high), -1, 1)[..., None]
    pale, blue, red = np.array([0.95, 0.94, 0.90]), np.array([0.10, 0.30, 0.72]), np.array([0.78, 0.16, 0.12])
    return np.where(t < 0, pale + (blue - pale) * -t, pale + (red - pale) * t)


def draw_borders(image, depth, project, lines, size) -> None:
    for points in lines:
        s = project(points)
        steps = max(2, int(np.abs(np.diff(s[:, :2], axis=0)).sum(0).max()) * 2)
        t = np.linspace(0, len(s) - 1, steps)
        i = np.minimum(t.astype(int), len(s) - 2)
        q = s[i] + (s[i + 1] - s[i]) * (t - i)[:, None]
        for dx, dy in ((0, 0), (1, 0), (0, 1)):
            x, y = q[:, 0].astype(int) + dx, q[:, 1].astype(int) + dy
            inside = (x >= 0) & (x < size) & (y >= 0) & (y < size)
            x, y, z = x[inside], y[inside], q[inside, 2]
            near = z > depth[y, x] - 2.5  # pixels of depth: the facets lie a little inside the surface
            image[y[near], x[near]] *= 0.55


def legend(image: Image.Image, span: tuple[float, float], text: str) -> None:
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(size=16)
    left, top, wide, high = 24, image.height - 58, 240, 14
    low, highest = span
    bar = (ramp(np.linspace(low, highest, wide), span) * 255).astype(np.uint8)
    image.paste(Image.fromarray(np.tile(bar, (high, 1, 1))), (left, top))
    for value in (low, 0.0, highest):
        x = left + (value - low) / (highest - low) * wide
        draw.text((x, top + high + 3), f"{value:g}", fill=(40, 40, 40), font=font, anchor="ma")
    draw.text((left, top - 22), text, fill=(40, 40, 40), font=font)


def shots(step: Path, view: tuple[float, float], radius: float, fineness: int) -> dict[str, Image.Image]:
    """Shaded with borders (""), and coloured by curvature ("-curvature")."""
    model = Model(step)
    points, normals, means, triangles = mesh(model, fineness)
    size = WIDTH * SUPER
    project, axes = look(points, view, size)
    depth, owner, weights = rasterize(project(points), triangles, size)
    covered = (owner >= 0)[..., None]
    normal = interpolate(normals, triangles, owner, weights)
    lines = borders(model)
    pictures = {}
    for suffix, colour in (("", STEEL), ("-curvature", ramp(interpolate(means * radius, triangles, owner, weights), CURVATURE_RANGE))):
        image = np.where(covered, shade(normal, axes, colour, 0.6 if suffix else 0.4), 1.0)
        if not suffix:
            draw_borders(image, depth, project, lines, size)
        picture = Image.fromarray((image * 255).astype(np.uint8)).resize((WIDTH, WIDTH), Image.Resampling.LANCZOS)
        if suffix:
            legend(picture, CURVATURE_RANGE, "mean curvature x radius")
        pictures[suffix] = picture
    return pictures


def save(picture: Image.Image, name: str) -> None:
    path = FOLDER / f"{name}.png"
    picture.save(path, optimize=True)
    print(f"pictures: {path.relative_to(program.ROOT)}", flush=True)


def render(step: Path, name: str, view: tuple[float, float], radius: float, fineness: int) -> None:
    pictures = shots(step, view, radius, fineness)
    save(pictures[""].quantize(224, dither=Image.Dither.NONE), name)  # a third of the bytes; colours would show bands
    save(pictures["-curvature"], f"{name}-curvature")


# --- what is shown ----------------------------------------------------------------------------------------------------------------


def star(directions, length: float, radii=None) -> dict:
    """One node; `radii` are pairs (at the node, at the far end), 1 where absent."""
    d = np.array(directions, float)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    return {"units": "mm", "nodes": [[0.0, 0.0, 0.0], *(length * d).tolist()],
            "struts": [{"a": 0, "b": i + 1, "ra": ra, "rb": rb} for i, (ra, rb) in enumerate(radii or [(1.0, 1.0)] * len(d))]}


SIGNS = (-1, 1)
BCC = [(x, y, z) for x in SIGNS for y in SIGNS for z in SIGNS]
FCC = [p for a in SIGNS for b in SIGNS for p in ((a, b, 0), (a, 0, b), (0, a, b))]
NODES = {
    "node-bcc": (star(BCC, 3.8), (28, 18)),
    "node-octet": (star(FCC, 3.8), (25, 22)),
    "node-mixed": (star([(1, 0.1, 0), (-0.8, 0.9, 0.2), (-0.3, -1, 0.3), (0.1, 0.2, 1), (0.4, -0.1, -1)], 6.0,
                        [(1.0, 1.0), (0.35, 0.35), (0.6, 1.1), (0.8, 0.3), (0.2, 0.2)]), (35, 28)),
    "node-irregular": (star(cases.star(9, 11)["nodes"][1:], 7.0), (40, 25)),
}


BLENDS = ("0.05", "0.15", "0.3")


def export(graph: Path, step: Path, *options: str) -> bool:
    done = program.run("export", graph, "-o", step, "--report", step.with_suffix(".report.json"), *options)
    if not done.ok:
        print(f"pictures: exit code {done.code} of `{done.command}`: {done.last_words}", file=sys.stderr)
    return done.ok


def render_blends(out: Path) -> bool:
    """One node with its valleys filled by three balls, side by side."""
    graph, view = NODES["node-irregular"]
    source, step = out / "node-blend.json", out / "node-blend.step"
    source.write_text(json.dumps(graph))
    row = Image.new("RGB", (len(BLENDS) * WIDTH, WIDTH), "white")
    for k, blend in enumerate(BLENDS):
        if not export(source, step, "--blend", blend):
            return False
        picture = shots(step, view, 1.0, 12)["-curvature"]
        ImageDraw.Draw(picture).text((WIDTH - 24, WIDTH - 30), f"--blend {blend}", fill=(40, 40, 40), font=ImageFont.load_default(size=24), anchor="rs")
        row.paste(picture, (k * WIDTH, 0))
    save(row.resize((row.width * 2 // 3, row.height * 2 // 3), Image.Resampling.LANCZOS), "node-blend")
    return True


def render_all(out: Path) -> int:
    FOLDER.mkdir(parents=True, exist_ok=True)
    failed = 0
    for name, (graph, view) in NODES.items():
        source, step = out / f"{name}.json", out / f"{name}.step"
        source.write_text(json.dumps(graph))
        if export(source, step):
            render(step, name, view, 1.0, 12)
        else:
            failed += 1
    failed += not render_blends(out)
    source, step = out / "cell-bcc.json", out / "cell-bcc.step"
    made = program.run("cell", "bcc", "--size", "10", "--repeat", "2x2x2", "--radius", "0.7", "-o", source)
    if made.ok and export(source, step):
        render(step, "cell-bcc", (32, 20), 0.7, 6)
    else:
        failed += 1
    return 1 if failed else 0
