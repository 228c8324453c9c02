#!/usr/bin/env python3
"""The paper's method in Python with the libraries the paper names, timed beside starbreak in one run.

usage: peer_python.py PATH_TO_STARBREAK [RUNS]

Written from the paper's text (Algorithm 1, eqs. 2-3, MST of the stressed nodes, OpenCV lines, a Gaussian blur
of 15 x 15 around every crack pixel); it is not the authors' code, which has no licence. KD-tree and Delaunay
from SciPy, minimum spanning tree by SciPy on the dense distance matrix, drawing and blur by OpenCV.
Both sides: one thread, 10^4 particles, radius 65 px, force 500, threshold 300, frame 1242 x 375.
"""
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import cv2
import numpy as np
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import Delaunay, KDTree
from scipy.spatial.distance import pdist, squareform

cv2.setNumThreads(1)
WIDTH, HEIGHT, PARTICLES, RADIUS, FORCE, THRESHOLD, KERNEL = 1242, 375, 10_000, 65.0, 500.0, 300.0, 15


def simulate(rng):
    """Propagated edges and stressed nodes, depth first, as Algorithm 1 reads."""
    points = rng.random((PARTICLES, 2)) * [WIDTH, HEIGHT]
    Delaunay(points)
    tree = KDTree(points)
    impact = int(rng.integers(PARTICLES))
    angle = rng.random() * 2 * math.pi
    stress = np.zeros(PARTICLES)
    visited = np.zeros(PARTICLES, bool)
    visited[impact] = True
    edges, fronts = [], []

    def gather(node, force, direction):
        near = np.array([k for k in tree.query_ball_point(points[node], RADIUS) if k != node])
        way = points[near] - points[node]
        way /= np.linalg.norm(way, axis=1, keepdims=True)
        return near, way, force * (way @ direction)

    near, way, handed = gather(impact, FORCE, np.array([math.cos(angle), math.sin(angle)]))
    stress[near] += np.maximum(handed, 0)
    for node, direction, force in zip(near, way, handed):
        if force > THRESHOLD:
            visited[node] = True
            edges.append((impact, node))
            fronts.append((node, force, direction))
    while fronts:
        node, force, direction = fronts.pop()
        near, way, handed = gather(node, force, direction)
        stress[near] += handed
        best = int(np.argmax(handed))
        if handed[best] > THRESHOLD and not visited[near[best]]:
            visited[near[best]] = True
            edges.append((node, near[best]))
            fronts.append((near[best], handed[best], way[best]))
    return points, edges, np.flatnonzero((stress > THRESHOLD) | visited)


def spanning_tree(points, stressed):
    """Edges of the minimum spanning tree that are no longer than the radius."""
    found = minimum_spanning_tree(squareform(pdist(points[stressed]))).tocoo()
    return [(stressed[a], stressed[b]) for a, b, length in zip(found.row, found.col, found.data) if length <= RADIUS]


def render(image, points, edges):
    """Grey lines by the sun's azimuth, then a blur of the neighborhood of every crack pixel."""
    layer = np.zeros(image.shape[:2], np.uint8)
    sun = np.array([math.cos(math.radians(35)), math.sin(math.radians(35))])
    for a, b in edges:
        normal = (points[b] - points[a])[::-1] * [-1, 1]
        level = 200 * abs(normal @ sun) / np.linalg.norm(normal)
        cv2.line(layer, tuple(map(int, points[a])), tuple(map(int, points[b])), max(1, int(level)), 1, cv2.LINE_AA)
    blended = np.where(layer[..., None] > 0, layer[..., None], image)
    out, reach = blended.copy(), KERNEL // 2
    for y, x in zip(*np.nonzero(layer)):
        window = np.s_[max(0, y - reach):y + reach + 1, max(0, x - reach):x + reach + 1]
        out[window] = cv2.GaussianBlur(blended[window], (KERNEL, KERNEL), 0)
    return out


def peer_ms(seed, image):
    start = time.process_time()
    points, edges, stressed = simulate(np.random.default_rng(seed))
    simulated = time.process_time()
    edges = edges + spanning_tree(points, stressed)
    joined = time.process_time()
    render(image, points, edges)
    return [1e3 * t for t in (simulated - start, joined - simulated, time.process_time() - joined)]


def main():
    starbreak, runs = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 15
    with tempfile.TemporaryDirectory() as folder:
        bench = [starbreak, "bench", "--model", "paper", "--particles", str(PARTICLES), "--runs", str(runs), "--json", "--quiet", "--replace", "-o", folder]
        before = json.loads(subprocess.run(bench, check=True, capture_output=True).stdout)
        image = np.full((HEIGHT, WIDTH, 3), 120, np.uint8)
        peer_ms(0, image)
        times = [peer_ms(seed, image) for seed in range(1, runs + 1)]
        after = json.loads(subprocess.run(bench, check=True, capture_output=True).stdout)
    totals = [sum(row) for row in times]
    print(f"{runs} runs each, medians, ms (CPU time of the Python process, wall clock of starbreak, one thread)")
    for name, column in zip(("mesh + propagation", "spanning tree", "draw + render"), zip(*times)):
        print(f"  Python: {name:20} {statistics.median(column):9.1f}")
    ours = statistics.mean(run["series"][0]["total_ms"]["median"] for run in (before, after))
    print(f"  Python: total                {statistics.median(totals):9.1f} ({min(totals):.1f}-{max(totals):.1f})")
    print(f"  starbreak: total             {ours:9.2f} (before and after the Python runs)")
    print(f"  ratio                        {statistics.median(totals) / ours:9.0f}")


if __name__ == "__main__":
    main()
