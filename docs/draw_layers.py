"""Draw the layers of the packages, and the imports between them: `python -m docs.draw_layers` writes docs/layers.svg.

The layers are those of tests/architecture, the arrows those of the source. The picture omits arrows that a chain of
others implies, and `__main__` modules, the entry points of packages.
"""

from collections import Counter
from functools import cache
from itertools import pairwise
from typing import NamedTuple

from tests.support.layers import LAYERS
from tests.support.paths import DOCS
from tests.support.source import arrows

PICTURE = DOCS / "layers.svg"

WIDTH = 1040
ROW, BOX_WIDTH, BOX_HEIGHT, GAP = 44, 132, 26, 22
TOP, MARGIN = 50, 16
"""Height of the heading, and margin around the layers."""

LANES = {"agents": 240.0, "field": 475.0, "world": 800.0, "fes": 560.0, "console": 800.0}
"""Center of each package's boxes."""

COLORS = {
    "fes": ("#D6E6F5", "#1F5F99"),
    "agents": ("#DDF0DC", "#2E7D32"),
    "world": ("#FCE5CD", "#B45F06"),
    "field": ("#F9D9D5", "#A3352A"),
    "console": ("#E9DDF3", "#6A3D9A"),
}
"""Fill of a package's boxes; color of their frames and of the arrows from them."""

STYLE = "font-family: Helvetica, Arial, DejaVu Sans, sans-serif; font-size: 13px"


class Point(NamedTuple):
    """A place in the picture [px], y downwards."""

    x: float
    y: float


def is_entry_point(package: str) -> bool:
    """True if a package is the module that `python -m` runs."""
    return package.endswith(".__main__")


def direct_arrows() -> dict[str, list[str]]:
    """The imports of each package that no chain of other imports implies."""
    imported = {name: targets for name, targets in arrows().items() if not is_entry_point(name)}

    @cache
    def reached(name: str) -> frozenset[str]:
        return frozenset(imported[name]).union(*(reached(target) for target in imported[name]))

    return {
        name: sorted(target for target in targets if not any(target in reached(step) for step in targets - {target}))
        for name, targets in imported.items()
    }


def positions(imports: dict[str, list[str]]) -> dict[str, Point]:
    """The center of each box: a row per layer, in each row in the order of the boxes that they import."""
    layers = [sorted(name for name in layer if not is_entry_point(name)) for layer in LAYERS]
    layers = [layer for layer in layers if layer]
    centers: dict[str, Point] = {}
    for row, layer in enumerate(layers):
        y = TOP + ROW * (len(layers) - row - 0.5)
        for top, lane in LANES.items():
            boxes = [name for name in layer if name.startswith(f"{top}.")]
            boxes.sort(key=lambda name: (_mean([centers[target].x for target in imports[name]], lane), name))
            for index, name in enumerate(boxes):
                shift = (index - (len(boxes) - 1) / 2) * (BOX_WIDTH + GAP)
                centers[name] = Point(lane + shift, y)
    return centers


def route(start: Point, end: Point, centers: list[Point], passed: Counter[tuple[Point, int]]) -> list[Point]:
    """Points of an arrow from `start` down to `end` that passes beside the boxes of the rows between them.

    `passed` counts the arrows that pass each side of a box, so that they run beside each other.
    """
    points = [start, end]
    between = [center for center in centers if start.y < center.y < end.y]
    while hit := _first_hit(points, between):
        index, box = hit
        x = _at(points[index], points[index + 1], box.y)
        row = [center for center in between if center.y == box.y]
        sides = [(center, side) for center in row for side in (-1, 1)]
        beside = {key: key[0].x + key[1] * (BOX_WIDTH / 2 + 9 + 5 * passed[key]) for key in sides}
        key = min(sides, key=lambda key: abs(beside[key] - x))
        passed[key] += 1
        points[index + 1 : index + 1] = [Point(beside[key], box.y + dy) for dy in (-BOX_HEIGHT / 2, BOX_HEIGHT / 2)]
        between = [center for center in between if center.y != box.y]
    return points


def path(points: list[Point]) -> str:
    """A smooth curve through `points`, vertical at each, as the data of an SVG path."""
    curve = [f"M{points[0].x:.1f},{points[0].y:.1f}"]
    for first, second in pairwise(points):
        third = (second.y - first.y) / 3
        before, after = f"{first.x:.1f},{first.y + third:.1f}", f"{second.x:.1f},{second.y - third:.1f}"
        curve.append(f"C{before} {after} {second.x:.1f},{second.y:.1f}")
    return " ".join(curve)


def port(x: float, ends: list[tuple[float, str]], end: tuple[float, str]) -> float:
    """The x on a box centered at `x` of the arrow to or from `end`: all `ends` stand side by side, in their order."""
    spread = min(18.0, (BOX_WIDTH - 24) / max(1, len(ends)))
    return x + (sorted(ends).index(end) - (len(ends) - 1) / 2) * spread


def draw() -> str:
    """The picture as SVG."""
    imports = direct_arrows()
    centers = positions(imports)
    height = max(center.y for center in centers.values()) + ROW / 2 + MARGIN
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height:.0f}" '
        f'viewBox="0 0 {WIDTH} {height:.0f}" style="{STYLE}">',
        "<title>Layers of the packages, and the imports between them</title>",
        f'<rect width="{WIDTH}" height="{height:.0f}" fill="white"/>',
        *(_arrowhead(top, color) for top, (_, color) in COLORS.items()),
    ]
    for index, y in enumerate(sorted({center.y for center in centers.values()})):
        shade = "#F7F7F7" if index % 2 else "#FFFFFF"
        parts.append(
            f'<rect x="{MARGIN}" y="{y - ROW / 2:.0f}" width="{WIDTH - 2 * MARGIN}" height="{ROW}" fill="{shade}"/>'
        )
    parts += _legend()
    passed: Counter[tuple[Point, int]] = Counter()
    importers = {name: [source for source in imports if name in imports[source]] for name in imports}
    for name, targets in sorted(imports.items()):
        for target in targets:
            outgoing = [(centers[each].x, each) for each in targets]
            incoming = [(centers[each].x, each) for each in importers[target]]
            start = Point(port(centers[name].x, outgoing, (centers[target].x, target)), centers[name].y)
            tip = Point(port(centers[target].x, incoming, (centers[name].x, name)), centers[target].y)
            start, tip = start._replace(y=start.y + BOX_HEIGHT / 2), tip._replace(y=tip.y - BOX_HEIGHT / 2 - 1)
            top = name.partition(".")[0]
            parts.append(
                f'<path d="{path(route(start, tip, list(centers.values()), passed))}" fill="none" '
                f'stroke="{COLORS[top][1]}" stroke-width="1" marker-end="url(#{top})"/>'
            )
    parts += [_box(center.x, center.y, name) for name, center in sorted(centers.items())]
    return "\n".join([*parts, "</svg>", ""])


def _at(first: Point, second: Point, y: float) -> float:
    """The x of a curve's piece between two points at `y`."""
    part = (y - first.y) / (second.y - first.y)
    return first.x + (second.x - first.x) * part * part * (3 - 2 * part)


def _first_hit(points: list[Point], boxes: list[Point]) -> tuple[int, Point] | None:
    """The first piece of a curve that crosses a box, and that box."""
    for index, (first, second) in enumerate(pairwise(points)):
        for box in sorted(boxes, key=lambda box: box.y):
            heights = [box.y + part * BOX_HEIGHT for part in (-0.5, 0.0, 0.5)]
            crossed = [_at(first, second, y) for y in heights if first.y <= y <= second.y]
            if any(abs(x - box.x) < BOX_WIDTH / 2 + 6 for x in crossed):
                return index, box
    return None


def _mean(values: list[float], default: float) -> float:
    return sum(values) / len(values) if values else default


def _box(x: float, y: float, name: str) -> str:
    fill, color = COLORS[name.partition(".")[0]]
    return (
        f'<rect x="{x - BOX_WIDTH / 2:.1f}" y="{y - BOX_HEIGHT / 2:.1f}" width="{BOX_WIDTH}" height="{BOX_HEIGHT}" '
        f'rx="5" fill="{fill}" stroke="{color}"/>'
        f'<text x="{x:.1f}" y="{y + 4.5:.1f}" text-anchor="middle" fill="#222222">{name}</text>'
    )


def _arrowhead(top: str, color: str) -> str:
    return (
        f'<marker id="{top}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        f'<path d="M0,1 L8,4 L0,7 z" fill="{color}"/></marker>'
    )


def _legend() -> list[str]:
    texts = {
        "console": "what a person runs",
        "agents": "robots",
        "world": "simulated truth",
        "field": "real robots",
        "fes": "shared by all",
    }
    parts, x = list[str](), float(MARGIN)
    for top, text in texts.items():
        fill, color = COLORS[top]
        parts += [
            f'<rect x="{x:.0f}" y="18" width="16" height="16" rx="3" fill="{fill}" stroke="{color}"/>',
            f'<text x="{x + 23:.0f}" y="31" fill="#222222"><tspan font-weight="bold">{top}</tspan> {text}</text>',
        ]
        x += 205
    return parts


def main() -> None:
    """Write the picture."""
    PICTURE.write_text(draw(), encoding="utf-8")


if __name__ == "__main__":
    main()
