"""Draws the figures of docs/evaluation.md from what `lattice-brep evaluate` writes; into docs/pictures/.

    validation/.venv/bin/python validation/figures.py surfaces          figures 14 and 15 of the paper: curvature and distance
    validation/.venv/bin/python validation/figures.py trade FILE..      deviation against fairness, from `evaluate nodes --trade --json FILE`
"""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import pictures
import ply
import program

SETS = ("regular-6", "regular-12", "regular-20", "irregular-6", "irregular-12", "irregular-20")
ROWS = (("Savio", "savio-mesh"), ("ours", "ours-patches"))
TILE, SUPER, MARGIN = 230, 2, 66  # pixels of a tile, how many of ours make one along each axis, room for names on the left
VIEW = (28, 18)
INK = (40, 40, 40)
CAP = (0.55, 0.56, 0.58)
CURVATURE, DISTANCE = (-3.0, 1.0), (-0.3, 0.3)  # 1/mm and mm: both methods and all nodes on one scale


# --- surfaces ---------------------------------------------------------------------------------------------------------------------


def normals(surface: ply.Surface) -> np.ndarray:
    a, b, c = (surface.points[surface.triangles[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    out = np.zeros_like(surface.points)
    for k in range(3):
        np.add.at(out, surface.triangles[:, k], cross)
    return out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-300)


def caps(surface: ply.Surface) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of the discs in the rims, so that nobody looks into the node."""
    points, triangles = [], []
    turn = np.linspace(0, 2 * np.pi, 65)[:-1]
    for axis in surface.axes:
        height = surface.points @ axis
        radius = np.linalg.norm(surface.points - height[:, None] * axis, axis=1)
        cut = height[np.abs(radius - 1) < 1e-9].max()
        side = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
        side /= np.linalg.norm(side)
        first = len(surface.points) + sum(map(len, points))
        points.append(np.vstack([cut * axis, cut * axis + np.outer(np.cos(turn), side) + np.outer(np.sin(turn), np.cross(axis, side))]))
        around = first + 1 + np.arange(len(turn))
        triangles.append(np.stack([np.full(len(turn), first), around, np.roll(around, -1)], 1))
    return np.vstack(points), np.vstack(triangles)


def tile(surface: ply.Surface, values: np.ndarray, span: tuple[float, float]) -> Image.Image:
    size = TILE * SUPER
    discs, fans = caps(surface)
    colours = np.vstack([pictures.ramp(values, span), np.tile(CAP, (len(discs), 1))])
    towards_us = np.vstack([normals(surface), np.tile((0.0, 0.0, 0.0), (len(discs), 1))])
    surface = ply.Surface(surface.axes, np.vstack([surface.points, discs]), surface.distances, surface.means, np.vstack([surface.triangles, fans]))
    project, axes = pictures.look(surface.points, VIEW, size)
    screen = project(surface.points)
    a, b, c = (screen[surface.triangles[:, k], :2] for k in range(3))
    towards = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) < (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])  # pixel rows count downward
    triangles = surface.triangles[towards]
    _, owner, weights = pictures.rasterize(screen, triangles, size)
    colour = pictures.interpolate(colours, triangles, owner, weights)
    normal = pictures.interpolate(towards_us, triangles, owner, weights)
    image = np.where((owner >= 0)[..., None], pictures.shade(normal, axes, colour, 0.75), 1.0)
    return Image.fromarray((image * 255).astype(np.uint8)).resize((TILE, TILE), Image.Resampling.LANCZOS)


def sheet(folder: Path, name: str, span: tuple[float, float], text: str, pick) -> None:
    image = Image.new("RGB", (MARGIN + TILE * len(SETS), 30 + TILE * len(ROWS) + 70), "white")
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(size=16)
    for column, node in enumerate(SETS):
        draw.text((MARGIN + TILE * (column + 0.5), 6), node, fill=INK, font=font, anchor="ma")
        for row, (method, file) in enumerate(ROWS):
            surface = ply.read(folder / f"{node}-{file}.ply")
            image.paste(tile(surface, pick(surface), span), (MARGIN + TILE * column, 30 + TILE * row))
            draw.text((8, 30 + TILE * (row + 0.5)), method, fill=INK, font=font, anchor="lm")
    pictures.legend(image, span, text)
    save(image, name)


def save(image: Image.Image, name: str) -> None:
    path = pictures.FOLDER / name
    image.quantize(96, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"figures: {path.relative_to(program.ROOT)}, {path.stat().st_size / 1000:.0f} kB")


def surfaces() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        done = program.run("evaluate", "nodes", "--sets", ",".join(SETS), "--count", 1, "--samples", 1, "--surfaces", folder)
        if not done.ok:
            print(done.last_words, file=sys.stderr)
            return 1
        sheet(folder, "evaluation-curvature.png", CURVATURE, "mean curvature, 1/mm", lambda s: s.means)
        sheet(folder, "evaluation-distance.png", DISTANCE, "distance from the original node, mm", lambda s: s.distances)
    return 0


# --- deviation against fairness ---------------------------------------------------------------------------------------------------

LINES = {"regular-6": (31, 119, 180), "regular-12": (23, 160, 134), "cuboctahedron": (120, 120, 120), "regular-20": (192, 57, 43),
         "irregular-6": (120, 170, 220), "irregular-12": (110, 205, 170), "irregular-20": (235, 140, 120)}


def median(nodes: list[dict], reading: int, figure) -> float:
    return float(np.median([figure(node["patches"][reading]) for node in nodes if node["patches"][reading]]))


def curve(figures: dict) -> list[tuple[float, float, float]]:
    """(hold, Avg, 99 % of |H|) of the patches, median over the nodes, from smooth to close."""
    rows = [(float(name.split()[1]), k) for k, name in enumerate(figures["readings"]) if name.startswith("hold")]
    pick = lambda k, figure: median(figures["nodes"], k, figure)  # noqa: E731
    return [(hold, pick(k, lambda p: p["deviation"]["avg"]), pick(k, lambda p: p["usual_mean_curvature"])) for hold, k in sorted(rows)]


def big(*points: tuple[float, float]) -> list[tuple[float, float]]:
    return [tuple(SUPER * c for c in p) for p in points]


def frame(draw: ImageDraw.ImageDraw, box: tuple[int, int, int, int], points: np.ndarray, ticks: tuple, texts: tuple[str, str]):
    """A frame with two logarithmic axes around the points; functions from values to places, in pixels before SUPER."""
    left, top, right, bottom = box
    font = ImageFont.load_default(size=15 * SUPER)
    (x0, x1), (y0, y1) = ((0.9 * points[:, k].min(), 1.1 * points[:, k].max()) for k in (0, 1))
    at_x = lambda x: left + (np.log(x / x0) / np.log(x1 / x0)) * (right - left)  # noqa: E731
    at_y = lambda y: bottom - (np.log(y / y0) / np.log(y1 / y0)) * (bottom - top)  # noqa: E731
    for x in [t for t in ticks[0] if x0 < t < x1]:
        draw.line(big((at_x(x), top), (at_x(x), bottom)), fill=(225, 225, 225), width=SUPER)
        draw.text(big((at_x(x), bottom + 8))[0], f"{x:g}", fill=INK, font=font, anchor="ma")
    for y in [t for t in ticks[1] if y0 < t < y1]:
        draw.line(big((left, at_y(y)), (right, at_y(y))), fill=(225, 225, 225), width=SUPER)
        draw.text(big((left - 8, at_y(y)))[0], f"{y:g}", fill=INK, font=font, anchor="rm")
    draw.rectangle(big((left, top), (right, bottom)), outline=INK, width=SUPER)
    draw.text(big(((left + right) / 2, bottom + 34))[0], texts[0], fill=INK, font=font, anchor="ma")
    draw.text(big((left, top - 6))[0], texts[1], fill=INK, font=font, anchor="ls")
    return at_x, at_y


def trade(files: list[str]) -> int:
    sets = [figures for file in files for figures in json.loads(Path(file).read_text())]
    curves = {figures["set"]: curve(figures) for figures in sets}
    width, high, left, top, right, bottom = 900, 620, 80, 30, 730, 550
    every = np.array([point for points in curves.values() for point in points])[:, 1:]
    image = Image.new("RGB", (width * SUPER, high * SUPER), "white")
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(size=15 * SUPER)
    at_x, at_y = frame(draw, (left, top, right, bottom), every, ((0.003, 0.005, 0.01, 0.02, 0.03, 0.05), (2, 3, 5, 10, 20, 50, 100)),
                       ("Avg distance from the original node, mm", "99 % of |H|, 1/mm"))
    for k, (name, points) in enumerate(curves.items()):
        places = [(at_x(avg), at_y(bend)) for _, avg, bend in points]
        draw.line(big(*places), fill=LINES[name], width=2 * SUPER)
        for (x, y), (hold, _, _) in zip(places, points):
            size = 6 if hold == 2 else 3
            draw.ellipse(big((x - size, y - size), (x + size, y + size)), fill=LINES[name])
        draw.line(big((right + 14, top + 14 + 24 * k), (right + 34, top + 14 + 24 * k)), fill=LINES[name], width=3 * SUPER)
        draw.text(big((right + 42, top + 14 + 24 * k))[0], name, fill=INK, font=font, anchor="lm")
    draw.text(big((right + 14, top + 30 + 24 * len(curves)))[0], "large dots: hold 2", fill=INK, font=font)
    save(image.resize((width, high), Image.Resampling.LANCZOS), "evaluation-trade.png")
    print("| set | " + " | ".join(f"{hold:g}" for hold, _, _ in next(iter(curves.values()))) + " |")
    for name, points in curves.items():
        print(f"| {name} | " + " | ".join(f"{avg:.4f}, {bend:.1f}" for _, avg, bend in points) + " |")
    return 0


if __name__ == "__main__":
    if sys.argv[1:] == ["surfaces"]:
        sys.exit(surfaces())
    if len(sys.argv) > 2 and sys.argv[1] == "trade":
        sys.exit(trade(sys.argv[2:]))
    sys.exit(__doc__)
