#!/usr/bin/env python3
"""Drops that are not round: the form that starbreak gives them against that of least area.

Water of a given volume on an outline that holds it has the surface of least area. It is found here by linear
triangles and Picard's iteration of div(grad h / sqrt(1 + |grad h|^2)) = -p, and compared with the closed form of
`crates/deposit/src/outline`: heights, directions of the normal, contact angles. Ends with 1 where normals are off by more
than 2.5 degrees (root mean square over the area), or where the true contact angle leaves what the recipe's hysteresis
holds by more than 2 degrees.

Usage: drop_outlines.py
"""

import sys

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

N_RADII, N_ANGLES = 40, 128


class Form:
    """The closed form; bulges are complex a_k + i b_k by k."""

    def __init__(self, bulges, contact_rad):
        self.bulges = bulges
        self.wide, self.face = np.sin(contact_rad), np.cos(contact_rad)
        self.stretch = np.sqrt(1 + sum(k * abs(c) ** 2 for k, c in bulges.items()))

    def level(self, z):
        z = z * self.stretch
        return abs(z) ** 2 - 2 * sum((np.conj(c) * z**k).real for k, c in self.bulges.items())

    def height(self, z):
        """In radii of the footprint."""
        return (np.sqrt(np.maximum(1 - self.wide**2 * self.level(z), 0)) - self.face) / self.wide

    def normal(self, z):
        w = z * self.stretch
        slope = w - np.conj(sum(k * np.conj(c) * w ** (k - 1) for k, c in self.bulges.items()))
        slope = slope * self.stretch * self.wide
        up = np.sqrt(np.maximum(1 - self.wide**2 * self.level(z), 1e-9))
        normal = np.stack([slope.real, slope.imag, up], 1)
        return normal / np.linalg.norm(normal, axis=1)[:, None]

    def rim(self, angles):
        low, high = np.full(len(angles), 0.5), np.full(len(angles), 1.8)
        for _ in range(60):
            middle = 0.5 * (low + high)
            inside = self.level(middle * np.exp(1j * angles)) < 1
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        return low


def mesh(rim, angles):
    radii = np.linspace(0, 1, N_RADII + 1)[1:]
    z = np.concatenate([[0], (radii[:, None] * (rim * np.exp(1j * angles))[None]).ravel()])
    triangles = [(0, 1 + j, 1 + (j + 1) % N_ANGLES) for j in range(N_ANGLES)]
    for i in range(N_RADII - 1):
        for j in range(N_ANGLES):
            a, b = 1 + i * N_ANGLES + j, 1 + i * N_ANGLES + (j + 1) % N_ANGLES
            c, d = a + N_ANGLES, b + N_ANGLES
            triangles += [(a, c, d), (a, d, b)]
    return z, np.array(triangles)


def compare(bulges, contact_deg):
    form = Form(bulges, np.radians(contact_deg))
    angles = 2 * np.pi * np.arange(N_ANGLES) / N_ANGLES
    z, triangles = mesh(form.rim(angles), angles)
    n, free = len(z), np.arange(len(z)) < len(z) - N_ANGLES
    corners = np.stack([z.real, z.imag], 1)[triangles]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    double = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    area = double / 2
    hats = np.zeros((len(triangles), 3, 2))
    for k in range(3):
        side = corners[:, (k + 2) % 3] - corners[:, (k + 1) % 3]
        hats[:, k] = np.stack([-side[:, 1], side[:, 0]], 1) / double[:, None]
    lumped = np.bincount(triangles.ravel(), np.repeat(area / 3, 3), n)
    said = np.where(free, form.height(z), 0)
    volume, height = (lumped * said).sum(), said
    rows, columns = np.repeat(triangles, 3, 1).ravel(), np.tile(triangles, (1, 3)).ravel()
    for _ in range(500):
        rise = np.einsum("tk,tkd->td", height[triangles], hats)
        weight = area / np.sqrt(1 + (rise**2).sum(1))
        parts = np.einsum("t,tid,tjd->tij", weight, hats, hats).ravel()
        matrix = coo_matrix((parts, (rows, columns)), (n, n)).tocsr()[free][:, free]
        answer = spsolve(matrix.tocsc(), lumped[free])
        new = np.zeros(n)
        new[free] = answer * volume / (lumped[free] @ answer)
        change, height = abs(new - height).max(), 0.5 * (height + new)
        if change < 1e-7:
            break
    else:
        raise SystemExit("the iteration does not settle")
    rise = np.einsum("tk,tkd->td", height[triangles], hats)
    normal = np.concatenate([-rise, np.ones((len(rise), 1))], 1)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    middles = z[triangles].mean(1)

    def off_deg(other):
        angle = np.degrees(np.arccos(np.clip((normal * other).sum(1), -1, 1)))
        return np.sqrt((area * angle**2).sum() / area.sum())

    at_rim = (triangles >= n - N_ANGLES).sum(1) == 2
    contact = np.degrees(np.arccos(normal[at_rim, 2]))
    off_height = np.sqrt((lumped * (height - said) ** 2).sum() / lumped.sum()) / height.max()
    round_drop = Form({}, np.radians(contact_deg))
    return off_height, off_deg(form.normal(middles)), off_deg(round_drop.normal(middles)), contact


def main():
    print("validation/drop_outlines.py")
    print("contact: angle, from which to which the recipe's hysteresis holds; bulges as far as they are allowed")
    print(f"{'contact':>16} {'bulges':38} {'height':>8} {'normal':>8} {'of a round drop':>16} {'true contact':>14}")
    cases = [
        (50, (35, 65), {}),
        (50, (35, 65), {2: 0.25}),
        (50, (35, 65), {3: 0.0937}),
        (50, (35, 65), {4: 0.05}),
        (50, (35, 65), {5: 0.0312}),
        (50, (35, 65), {2: -0.125, 3: 0.0469j}),
        (50, (35, 65), {2: 0.1, 3: 0.02j, 4: 0.01, 5: 0.005j}),
        (30, (20, 40), {2: 0.25}),
        (30, (20, 40), {3: 0.0937}),
        (80, (65, 95), {2: 0.0797}),
        (80, (65, 95), {3: 0.0299}),
    ]
    failed = False
    for contact_deg, held, bulges in cases:
        off_height, off, of_round, contact = compare(bulges, contact_deg)
        # Of triangles at the rim the contact angle is a little less than at the rim itself.
        low, high = contact.min(), contact.max()
        is_off = off > 2.5 or low < held[0] - 2 or high > held[1] + 2
        failed |= is_off
        named = ", ".join(f"{k}: {c:.3g}" for k, c in bulges.items()) or "none"
        print(
            f"{contact_deg:4}, {held[0]} to {held[1]:2} {named:38} {100 * off_height:6.2f} % {off:6.2f}° {of_round:14.2f}° "
            f"{low:5.1f} to {high:4.1f}{'  OFF' if is_off else ''}"
        )
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
