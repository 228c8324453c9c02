"""Ghosts of a double Gauss lens, ray by ray.

    python validation/ghosts.py

An exact trace: rays meet spheres, are bent by Snell's law in full, and mirrored by two of them. For each pair of faces the
rays through the middle and the edges of the stop are found by bisection, for a lamp half a degree off the axis and a lens
of f/20. Prints, for each pair, the ghost's middle over the lamp's place, and its radius in focal lengths: the numbers of
`crates/optics/tests/stray_light.rs`. Needs the standard library alone.
"""

import math

RADIUS = [29.475, 84.83, 19.275, 40.77, 12.75, 0.0, -14.495, 40.77, -20.385, 437.065, -39.73]
GAP = [3.76, 0.12, 4.025, 3.275, 5.705, 4.5, 1.18, 6.065, 0.19, 3.22, 0.0]
INDEX = [1.67, 1.0, 1.67, 1.699, 1.0, 1.0, 1.603, 1.658, 1.0, 1.717, 1.0]
PLACE = [sum(GAP[:k]) for k in range(len(GAP))]
ANGLE = math.radians(0.5)
F_NUMBER = 20.0


def before(face):
    return INDEX[face - 1] if face else 1.0


def to_sphere(point, ray, face):
    """Where a ray in the plane of (z, y) meets a face, and the normal there, against the ray."""
    (z, y), (dz, dy) = point, ray
    radius = RADIUS[face]
    if radius == 0.0:
        t = (PLACE[face] - z) / dz
        return (z + t * dz, y + t * dy), None
    center = PLACE[face] + radius
    b = (z - center) * dz + y * dy
    c = (z - center) ** 2 + y * y - radius * radius
    root = math.sqrt(b * b - c)
    # The meeting nearest to the vertex.
    t = min((-b - root, -b + root), key=lambda t: abs(z + t * dz - PLACE[face]))
    hit = (z + t * dz, y + t * dy)
    normal = ((hit[0] - center) / radius, hit[1] / radius)
    if normal[0] * dz + normal[1] * dy > 0:
        normal = (-normal[0], -normal[1])
    return hit, normal


def bent(ray, normal, ratio):
    cos = -(ray[0] * normal[0] + ray[1] * normal[1])
    root = math.sqrt(1.0 - ratio * ratio * (1.0 - cos * cos))
    return tuple(ratio * d + (ratio * cos - root) * n for d, n in zip(ray, normal))


def mirrored(ray, normal):
    cos = ray[0] * normal[0] + ray[1] * normal[1]
    return tuple(d - 2.0 * cos * n for d, n in zip(ray, normal))


def path(pair):
    """Faces in the order in which a ray meets them, each with what it does: 1 goes on, -1 goes back, 0 is mirrored."""
    last = len(RADIUS)
    if pair is None:
        return [(k, 1) for k in range(last)]
    i, j = pair
    steps = [(k, 1) for k in range(j)] + [(j, 0)]
    steps += [(k, -1) for k in range(j - 1, i, -1)] + [(i, 0)]
    return steps + [(k, 1) for k in range(i + 1, last)]


def trace(height, angle, pair, sensor):
    """Height on a sensor, and where the stop is met; parallel light comes at an angle."""
    point, ray = (-1.0, height - math.tan(angle) * 1.0), (math.cos(angle), math.sin(angle))
    stops = []
    for face, does in path(pair):
        point, normal = to_sphere(point, ray, face)
        if RADIUS[face] == 0.0:
            stops.append(point[1])
            continue
        if does == 0:
            ray = mirrored(ray, normal)
        else:
            ratio = before(face) / INDEX[face] if does > 0 else INDEX[face] / before(face)
            ray = bent(ray, normal, ratio)
    t = (sensor - point[0]) / ray[0]
    return point[1] + t * ray[1], stops, (point, ray)


def solve(function, low, high):
    """A root by bisection."""
    sign = function(low) < 0
    for _ in range(200):
        middle = 0.5 * (low + high)
        if (function(middle) < 0) == sign:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def main():
    # The focus, by a ray near the axis.
    height = 1e-4
    _, _, (point, ray) = trace(height, 0.0, None, 100.0)
    sensor = point[0] - point[1] * ray[0] / ray[1]
    focal = -height * ray[0] / ray[1]
    pupil = 0.5 * focal / F_NUMBER
    stop = trace(pupil, 0.0, None, sensor)[1][0]
    own = trace(solve(lambda y: trace(y, ANGLE, None, sensor)[1][0], -3.0, 3.0), ANGLE, None, sensor)[0]
    print(f"focal length {focal:.4f}, lamp at {own / focal:.6f}, {math.tan(ANGLE):.6f}")
    faces = [k for k in range(len(RADIUS)) if RADIUS[k] != 0.0]
    for a, i in enumerate(faces):
        for j in faces[a + 1:]:
            pair = (i, j)
            # The way through the stop on which the pupil is narrowest.
            heights = [trace(1e-4, 0.0, pair, sensor)[1], trace(0.0, 0.0, pair, sensor)[1]]
            which = max(range(len(heights[0])), key=lambda k: abs(heights[0][k] - heights[1][k]))
            def at(y, k=which):
                return trace(y, ANGLE, pair, sensor)[1][k]
            slope = (heights[0][which] - heights[1][which]) / 1e-4
            guess = -at(0.0) / slope
            reach = abs(2.0 * stop / slope) + abs(guess)
            try:
                middle = solve(at, guess - reach, guess + reach)
                edges = [solve(lambda y: at(y) - side * stop * 0.1, guess - reach, guess + reach) for side in (-1, 1)]
                places = [trace(y, ANGLE, pair, sensor)[0] for y in (middle, *edges)]
            except ValueError:
                print(f"({i}, {j}, f64::NAN, f64::NAN),")
                continue
            radius = abs(places[2] - places[1]) / 2.0 / 0.1
            print(f"({i}, {j}, {places[0] / own:.4f}, {radius / focal:.5f}),")


if __name__ == "__main__":
    main()
