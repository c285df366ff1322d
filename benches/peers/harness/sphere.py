"""The mesh for the smooth-surface rows: an icosahedron with every face cut in four, twice, on the unit sphere."""

import math


def icosphere(times):
    g = (1 + math.sqrt(5)) / 2
    points = [unit(p) for s in (-1, 1) for t in (-g, g) for p in ((0, s, t), (s, t, 0), (t, 0, s))]
    short = 1.2
    triangles = [
        oriented(points, (a, b, c))
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if max(math.dist(points[a], points[b]), math.dist(points[b], points[c]), math.dist(points[c], points[a])) < short
    ]
    for _ in range(times):
        points, triangles = halved(points, triangles)
    return points, triangles


def unit(p):
    length = math.hypot(*p)
    return tuple(x / length for x in p)


def oriented(points, corners):
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (points[k] for k in corners)
    volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return corners if volume > 0 else corners[::-1]


def halved(points, triangles):
    points, middles = list(points), {}

    def middle(a, b):
        key = (min(a, b), max(a, b))
        if key not in middles:
            middles[key] = len(points)
            points.append(unit([x + y for x, y in zip(points[a], points[b])]))
        return middles[key]

    small = []
    for a, b, c in triangles:
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        small += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return points, small


def write_off(path, points, triangles):
    with open(path, "w") as out:
        out.write(f"OFF\n{len(points)} {len(triangles)} 0\n")
        out.writelines("{!r} {!r} {!r}\n".format(*p) for p in points)
        out.writelines("3 {} {} {}\n".format(*t) for t in triangles)
