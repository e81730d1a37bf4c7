"""The bar's guests' side: booths, tables, tiled columns, the stage with a piano, neon and lit signs, and what moves."""

import numpy as np

from supersampling.scenes.bar import parts
from supersampling.scenes.bar import shapes as forms
from supersampling.scenes.bar.materials import Palette
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.motion import rotation, spin, sway
from supersampling.scenes.kit.shapes import Shape, beam, box, cylinder, lathe, panel, plate, quad, sphere, tube

BOOTHS = (-4.9, -1.9, 1.1)
TABLES = ((-5.6, 0.9), (-3.9, 1.5), (-1.2, 1.1), (0.8, 1.4), (4.6, -0.4))
COLUMNS = ((-2.6, 1.9), (2.7, 1.9))
SCONCES = (
    *(((x, -4.98), 0) for x in (4.75, 7.2)),
    *(((x, 4.98), 180) for x in (-6.7, -3.4, -0.4, 3.1)),
    ((7.98, 0.75), -90),
    ((-7.98, 4.2), 90),
)
GLOBES = (*((x, -0.5) for x in (-6.4, -2.2, 2.6)), *((x, 2.8) for x in (-5.6, -0.8)))
BALL = (5.6, 2.75, 1.4)
_MARTINI = (
    (-0.3, 0.35),
    (0.3, 0.35),
    (0.0, 0.0),
    (0.0, -0.33),
    (-0.17, -0.38),
    (0.17, -0.38),
    (0.0, -0.33),
    (0.0, 0.0),
)


def booths(b: Builder, p: Palette) -> None:
    """Add benches along the south wall with tables, a lamp over each."""
    soft, hard = parts.bench(2.3)
    for k, x in enumerate(BOOTHS):
        b.put(soft.turn_y(180).shift(x, 0, 4.95), p.teal)
        b.put(hard.turn_y(180).shift(x, 0, 4.95), p.wood)
        for dx in (-0.55, 0.55):
            _table(b, p, x + dx, 3.95, 4 * k + (dx > 0))
    for x, z in TABLES:
        _table(b, p, x, z, int(10 * (x + z)))


def _table(b: Builder, p: Palette, x: float, z: float, seed: int) -> None:
    """Add a table with a candle, two glasses and one or two chairs around it."""
    rng = np.random.default_rng(abs(seed))
    top, foot = parts.table()
    b.put(top.shift(x, 0, z), (p.black, p.top, p.ruby)[seed % 3])
    b.put(foot.shift(x, 0, z), p.brass)
    b.put(lathe([(0, 0.02), (0.032, 0.09), (0.036, 0.09), (0.04, 0.05), (0.028, 0)], 12).shift(x, 0.74, z), p.candle)
    for _ in range(3):
        angle, reach = rng.uniform(0, 2 * np.pi), rng.uniform(0.14, 0.3)
        kind = int(rng.integers(3))
        place = (x + reach * float(np.sin(angle)), 0.74, z + reach * float(np.cos(angle)))
        b.put(parts.drinking_glass(kind).shift(*place), p.glass[4] if kind == 0 else p.dark_glass)
    frame, seat = parts.chair()
    for turn in (0.0, 180.0) if z < 3 else (180.0,):
        # A chair looks along its +z, towards the table.
        way = turn + float(rng.uniform(-25, 25))
        sit = (x - 0.62 * np.sin(np.radians(way)), 0, z - 0.62 * np.cos(np.radians(way)))
        if z > 3:
            sit, way = (x, 0, z - 0.6), float(rng.uniform(-20, 20))
        b.put(frame.turn_y(way).shift(*sit), p.black)
        b.put(seat.turn_y(way).shift(*sit), p.red)


def columns(b: Builder, p: Palette) -> None:
    """Add columns of glazed tiles with brass edges."""
    for x, z in COLUMNS:
        b.put(box((0.45, 3.2, 0.45), (x, 1.8, z), ("front", "back", "left", "right")), p.dark_tiles)
        for y, wide, tall in ((0.1, 0.56, 0.2), (3.5, 0.6, 0.2)):
            b.put(box((wide, tall, wide), (x, y, z)), p.wood)
        for y in (0.21, 1.15, 3.39):
            b.put(box((0.49, 0.03, 0.49), (x, y, z)), p.brass)
        for dx in (-0.225, 0.225):
            for dz in (-0.225, 0.225):
                b.put(box((0.025, 3.2, 0.025), (x + dx, 1.8, z + dz)), p.brass)


def stage(b: Builder, p: Palette) -> None:
    """Add a low round stage in the south-east corner with a grand piano and its stool."""
    line = forms.rounded([(8.0, -0.2), (4.3, -0.2), (4.3, 5.0)][::-1], 1.6)
    b.put(forms.sweep(line[::-1], [(0.0, 0.2), (0.02, 0.19), (0.02, 0.17), (0.0, 0.16), (0.0, 0.0)]), p.wood)
    top = np.concatenate([line, [[8.0, 5.0]]])
    middle = top.mean(0)
    for a, c in zip(top, np.roll(top, -1, 0)):
        corners = np.array([[middle[0], 0.2, middle[1]], [c[0], 0.2, c[1]], [a[0], 0.2, a[1]]])
        if np.cross(corners[1] - corners[0], corners[2] - corners[0])[1] < 0:
            corners = corners[[0, 2, 1]]
        up = np.tile([0.0, 1.0, 0.0], (3, 1))
        b.put(Shape(corners, up, corners[:, [0, 2]], np.array([[0, 1, 2]])), p.top)
    for shape, material in _piano(p):
        b.put(shape.turn_y(-115).shift(6.3, 0.2, 2.7), material)
    chrome, brass, seat = parts.stool()
    for shape, material in ((chrome, p.chrome), (brass, p.brass), (seat, p.red)):
        b.put(shape.shift(5.2, -0.1, 2.3), material)


def _piano(p: Palette) -> list[tuple[Shape, int]]:
    """Return a grand piano with its lid open; the keys look along +z."""
    flat = rotation((1, 0, 0), -np.pi / 2)
    right = forms.rounded([(0.75, -0.62), (0.75, 0.1), (0.2, 0.45), (0.25, 1.05), (-0.5, 1.05)], 0.28, 6)
    left = np.stack([np.full(len(right), -0.75), np.linspace(-0.62, 1.0, len(right))], 1)
    body, lid = plate(right, left, 0.28).transform(flat).shift(0, 0.82, 0), plate(right, left, 0.025).transform(flat)
    lid = lid.shift(0.75, 0, 0).transform(rotation((0, 0, 1), 0.6)).shift(-0.75, 0.99, 0)
    black = [body, lid, beam((0.66, 0.96, 0.0), (0.5, 1.84, 0.0), 0.02)]
    black += [box((1.5, 0.06, 0.3), (0, 0.66, 0.76)), box((1.5, 0.26, 0.06), (0, 0.83, 0.6))]
    black += [box((0.09, 0.16, 0.3), (s * 0.705, 0.75, 0.76)) for s in (-1, 1)]
    leg = lathe([(0.07, 0.7), (0.04, 0.5), (0.06, 0.42), (0.035, 0.1), (0.05, 0.06), (0.03, 0)], 16)
    black += [leg.shift(*place) for place in ((-0.62, 0, 0.6), (0.62, 0, 0.6), (-0.4, 0, -0.75))]
    gold = panel((-0.7, 0.962, -0.9), (1.0, 0, 0), (0, 0, 1.4))
    keys = [box((0.024, 0.02, 0.15), (x, 0.7, 0.82)) for x in np.linspace(-0.63, 0.63, 50)]
    sharps = [
        box((0.012, 0.03, 0.09), (x, 0.71, 0.78))
        for i, x in enumerate(np.linspace(-0.617, 0.617, 49))
        if i % 7 not in (2, 6)
    ]
    pedals = [box((0.03, 0.015, 0.12), (x, 0.06, 0.45)) for x in (-0.06, 0.0, 0.06)] + [
        cylinder(0.02, 0.62, 8).shift(0, 0.37, 0.36)
    ]
    music = quad((-0.4, 1.2, 0.5), (0.8, 0, 0), (0, -0.22, 0.06))
    pieces = [(s, p.black) for s in (*black, *sharps, music, music.turn_y(180).shift(0, 0, 1.06))]
    pieces += [(s, p.cream) for s in keys] + [(s, p.brass) for s in pedals]
    return [*pieces, (gold, p.brass)]


def neons(b: Builder, p: Palette) -> None:
    """Add neon over the booths and on the east wall, lit signs on the walls."""
    martini = forms.neon(_MARTINI)
    olive = forms.neon(
        [(0.06 * np.sin(a) + 0.06, 0.22 + 0.06 * np.cos(a)) for a in np.arange(12) * np.pi / 6], closed=True
    )
    for x, back, shapes in (
        (-1.9, 1.5, ((forms.neon_letters("NEON", 0.42), "cyan"), (forms.neon([(-0.7, -0.33), (0.7, -0.33)]), "pink"))),
        (-4.9, 0.9, ((martini, "pink"), (olive, "amber"))),
        (1.1, 1.5, ((forms.neon_letters("BAR", 0.5), "amber"), (forms.neon([(-0.66, 0.36), (0.66, 0.36)]), "cyan"))),
    ):
        b.put(box((back + 0.1, 0.95, 0.03), (x, 2.15, 4.975)), p.black)
        for shape, color in shapes:
            b.put(shape.turn_y(180).shift(x, 2.15, 4.92), p.neon[color])
    word = forms.neon_letters("JAZZ", 0.7).turn_y(-90).shift(7.92, 2.5, 2.4)
    b.put(box((0.03, 1.1, 2.7), (7.975, 2.5, 2.4)), p.black)
    b.put(word, p.neon["pink"])
    for k, radius in enumerate((0.34, 0.28, 0.22)):
        ring = [(radius * np.cos(a), radius * np.sin(a)) for a in np.arange(30) * np.pi / 15]
        b.put(forms.neon(ring, closed=True).turn_y(-90).shift(7.94, 2.4, -2.4), p.neon[("amber", "pink", "cyan")[k]])
    b.put(quad((-1.0, 0.32, 0), (2.0, 0, 0), (0, -0.64, 0)).turn_y(-90).shift(7.93, 2.4, -0.6), p.signs[3])
    b.put(box((0.06, 0.7, 2.06), (7.965, 2.4, -0.6)), p.brass)
    b.put(quad((-0.9, 0.3, 0), (1.8, 0, 0), (0, -0.6, 0)).shift(5.9, 2.3, -4.93), p.signs[0])
    b.put(box((1.86, 0.66, 0.06), (5.9, 2.3, -4.965)), p.brass)


def movers(b: Builder, p: Palette) -> None:
    """Add two ceiling fans, a turning light box, a mirror ball and lamps that sway."""
    wood, brass = parts.fan(5, 0.75)
    for x, z, hertz in ((-4.4, 0.6, 0.45), (1.2, 0.6, -0.38)):
        b.put(cylinder(0.02, 0.4, 10).shift(x, 3.4, z), p.brass)
        b.move([(wood, p.wood), (brass, p.brass)], spin((x, 3.1, z), (0, 1, 0), hertz))
    front = quad((-0.5, 0.19, 0.07), (1.0, 0, 0), (0, -0.38, 0))
    case = [box((1.04, 0.42, 0.12)), cylinder(0.012, 0.5, 8).shift(0, 0.45, 0)]
    faces = [(front, p.signs[1]), (front.turn_y(180), p.signs[1])]
    b.move([*faces, *((s, p.chrome) for s in case)], spin((5.4, 2.55, -2.4), (0, 1, 0), 0.08))
    b.put(cylinder(0.02, 0.4, 8).shift(5.4, 3.4, -2.4), p.chrome)
    b.put(tube([(BALL[0], 3.6, BALL[2]), (BALL[0], BALL[1], BALL[2])], 0.008, 6), p.chrome)
    b.move([(forms.mirror_ball(0.3), p.chrome), (sphere(0.285, 12), p.black)], spin(BALL, (0, 1, 0), 0.06))
    shade, inside, bulb = parts.pendant(1.5)
    for k, x in enumerate(BOOTHS):
        shapes = [(shade, p.brass), (inside, p.cream), (bulb, p.bulb)]
        b.move(shapes, sway((x - 0.7, 3.6, 3.95), (0.5, 0, 1), 2.0 + 2.5 * (k == 1), 0.3 + 0.03 * k, 1.1 * k))


def sconces(b: Builder, p: Palette) -> None:
    """Add wall lamps: brass bracket and a glowing cup."""
    cup = lathe([(0, 0.02), (0.05, 0.1), (0.056, 0.1), (0.05, 0.02), (0.03, -0.02), (0, -0.04)], 12).shift(
        0, 0.03, 0.13
    )
    arm = [
        lathe([(0.03, 0.02), (0.035, 0), (0.01, -0.02)], 14).shift(0, 0, 0.13),
        box((0.09, 0.24, 0.02), (0, 0, 0.01)),
    ]
    arm.append(tube([(0, -0.05, 0.02), (0, -0.06, 0.08), (0, -0.05, 0.12), (0, 0, 0.13)], 0.01, 8))
    for (x, z), turn in SCONCES:
        b.put(cup.turn_y(turn).shift(x, 1.95, z), p.candle)
        for shape in arm:
            b.put(shape.turn_y(turn).shift(x, 1.95, z), p.brass)


def globes(b: Builder, p: Palette) -> None:
    """Add opal globes under the beams, over the aisles."""
    for x, z in GLOBES:
        b.put(sphere(0.11, 14).shift(x, 2.9, z), p.opal)
        b.put(
            lathe([(0.02, 0.52), (0.012, 0.5), (0.012, 0.12), (0.06, 0.11), (0.065, 0.08)], 12).shift(x, 2.9, z),
            p.brass,
        )


def jukebox(b: Builder, p: Palette) -> None:
    """Add a jukebox in the north-west corner: an arch of lacquer, glowing tubes and onyx."""
    angle = np.linspace(0, np.pi, 19)

    def arch(radius: float, foot: float) -> np.ndarray:
        bow = np.stack([radius * np.cos(angle), 1.05 + radius * np.sin(angle)], 1)
        return np.concatenate([[[radius, foot]], bow, [[-radius, foot]]])

    place = (-7.25, 0.0, -4.6)
    shapes = [(plate(arch(0.48, 0.0), arch(0.02, 0.0), 0.5), p.ruby), (box((0.86, 0.5, 0.06), (0, 0.25, 0.26)), p.wood)]
    shapes += [(box((0.7, 0.03, 0.02), (0, y, 0.295)), p.chrome) for y in (0.12, 0.2, 0.28, 0.36)]
    shapes += [
        (plate(arch(0.28, 0.56), arch(0.02, 0.56), 0.04).shift(0, 0, 0.25), p.onyx),
        (box((0.7, 0.05, 0.12), (0, 0.53, 0.28)), p.chrome),
    ]
    for radius, color in ((0.43, "amber"), (0.37, "pink"), (0.31, "cyan")):
        shapes.append((forms.neon(arch(radius, 0.6), 0.02).shift(0, 0, 0.265), p.neon[color]))
    for shape, material in shapes:
        b.put(shape.shift(*place), material)
