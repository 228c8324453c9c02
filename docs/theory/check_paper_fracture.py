"""Makes the numbers of paper-fracture.md.

    python3 docs/theory/check_paper_fracture.py CHECK [SEEDS]

CHECK is `reference`, `fan`, `rules`, `literal`, `radius`, `particles`, `stress` or `loss`. Needs
numpy and scipy; STARBREAK names the binary (default: `starbreak` on the PATH).

`propagate` below is the pseudo-code of the page, written without a look at the Rust code's data
structures: k-d tree instead of grid, scipy's Delaunay triangulation, dense minimum spanning tree.
"""

import json
import math
import os
import subprocess
import sys
import tempfile

import numpy as np
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import Delaunay, cKDTree

BINARY = os.environ.get("STARBREAK", "starbreak")
FRAME = (1242, 375)
RADIUS, FORCE, THRESHOLD = 65.0, 500.0, 300.0


def simulate(seed, size=FRAME, **keys):
    """Result line and network of `starbreak simulate`; `table__key` stands for table.key."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "network.json")
        command = [BINARY, "simulate", "--preset", "paper", "--seed", str(seed), "--size", f"{size[0]}x{size[1]}"]
        command += ["--json", "-q", "-o", path]
        for key, value in {"impact__0__position": "[0.5,0.5]", **keys}.items():
            command += ["--set", f"{key.replace('__', '.')}={value}"]
        out = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        with open(path, encoding="utf-8") as file:
            return json.loads(out), json.load(file)


def mesh_nodes(seed, count, position):
    """The nodes of a mesh: with a tiny threshold and a huge radius every one of them breaks."""
    result, network = simulate(
        seed, impact__0__position=position, impact__0__direction_deg=0, fracture__particles=count,
        fracture__neighbour_radius_px=3000, fracture__critical_stress=1e-9,
        fracture__two_sided="true",
    )
    nodes = network["nodes"]
    return np.c_[nodes["x"], nodes["y"]][: result["mesh"]["n_nodes"]]


def propagate(points, impact, v0, rule="algorithm-1", neighborhood="radius", two_sided=False,
              branches=1, steps_back=None):
    if neighborhood == "radius":
        tree = cKDTree(points)
        neighbors = lambda p: np.array(sorted(set(tree.query_ball_point(points[p], RADIUS)) - {p}))
    else:
        starts, ids = Delaunay(points).vertex_neighbor_vertices
        def neighbors(p):
            q = np.sort(ids[starts[p] : starts[p + 1]])
            return q[((points[q] - points[p]) ** 2).sum(1) <= RADIUS**2]
    stress, broken = np.zeros(len(points)), np.zeros(len(points), bool)
    hops, stack, changes = [], [], {}
    stops = {"below": 0, "crack": 0, "none": 0}
    fronts = 0

    def gather(p, f, v):
        q = neighbors(p)
        way = points[q] - points[p]
        return q, f * (way @ np.array(v)) / np.sqrt((way**2).sum(1)), way

    def hand_on(q, s, step):
        stress[q] += s
        changes[step] = max(changes.get(step, 0.0), np.abs(s).max(initial=0.0))

    def break_node(p, q, s, way, step):
        broken[q] = True
        hops.append((p, q))
        stack.append((q, s, way / math.hypot(*way), step + 1))

    stress[impact], broken[impact] = FORCE, True
    q, s, way = gather(impact, FORCE, v0)
    s = np.abs(s) if two_sided else np.maximum(s, 0)
    hand_on(q, s, 0)
    fronts += 1
    for i in range(len(q)):
        if s[i] > THRESHOLD and not broken[q[i]]:
            break_node(impact, q[i], s[i], way[i], 0)
    while stack:
        p, f, v, step = stack.pop()
        q, s, way = gather(p, f, v)
        hand_on(q, s, step)
        fronts += 1
        if rule == "caption":
            side = v[0] * way[:, 1] - v[1] * way[:, 0]
            q1, q2 = (np.maximum(s, 0)[mask].sum() for mask in (side >= 0, side <= 0))
            keep = side >= 0 if q1 >= q2 else side <= 0
            q, s, way = q[keep], s[keep], way[keep]
        elif rule == "literal":
            back = abs(np.minimum(s, 0).sum()) > np.maximum(s, 0).sum()
            if back:
                keep = s < 0
                q, s, way = q[keep], -s[keep], way[keep]
            if steps_back is not None:
                steps_back.append((back, back and (q[np.argmax(s)], p) in hops))
        left, advanced, reason = list(range(len(q))), False, "none"
        for _ in range(branches):
            if not left:
                break
            best = max(left, key=lambda i: (s[i], -q[i]))
            if s[best] <= THRESHOLD:
                reason = "below"
                break
            if broken[q[best]]:
                reason = "crack"
            else:
                break_node(p, q[best], s[best], way[best], step)
                advanced = True
            if branches > 1:
                left.remove(best)
        if not advanced:
            stops[reason] += 1
    stressed = np.flatnonzero((stress > THRESHOLD) | broken)
    return {"hops": hops, "stressed": stressed, "counts": (fronts, *stops.values(), len(changes))}


def reference():
    cases = [{}, {"rule": "caption"}, {"rule": "literal"}, {"neighborhood": "mesh-edges"},
             {"two_sided": True}, {"branches": 2}, {"branches": 3, "neighborhood": "mesh-edges"},
             {"rule": "caption", "branches": 2}, {"rule": "literal", "neighborhood": "mesh-edges"}]
    keys = {"rule": "fracture__rule", "neighborhood": "fracture__neighbourhood",
            "two_sided": "fracture__two_sided", "branches": "fracture__branches"}
    equal = 0
    meshes = [(1, 3000, (0.3, 0.5), 20), (2, 3000, (0.6, 0.4), 200), (3, 6000, (0.5, 0.5), 0)]
    for seed, count, (x, y), degrees in meshes:
        points = mesh_nodes(seed, count, f"[{x},{y}]")
        impact = int(np.argmin(((points - [x * FRAME[0], y * FRAME[1]]) ** 2).sum(1)))
        angle = math.radians(degrees)
        for case in cases:
            settings = {keys[k]: str(v).lower() for k, v in case.items()}
            result, _ = simulate(seed, fracture__particles=count, impact__0__position=f"[{x},{y}]",
                                 impact__0__direction_deg=degrees, **settings)
            own = propagate(points, impact, (math.cos(angle), math.sin(angle)), **case)
            report = result["convergence"]
            theirs = tuple(report[key] for key in ("n_fronts", "stopped_below_threshold",
                           "stopped_at_crack", "stopped_without_neighbor", "n_steps"))
            stressed = own["stressed"]
            places = points[stressed]
            apart = np.sqrt(((places[:, None] - places[None]) ** 2).sum(-1))
            tree = minimum_spanning_tree(apart).tocoo()
            pairs = {tuple(sorted(map(int, hop))) for hop in own["hops"]}
            pairs |= {tuple(sorted((int(stressed[i]), int(stressed[j]))))
                      for i, j, length in zip(tree.row, tree.col, tree.data) if length <= RADIUS}
            length = sum(math.dist(points[i], points[j]) for i, j in pairs)
            gap = abs(length - result["summary"]["total_length"])
            same = own["counts"] == theirs and len(stressed) == result["mesh"]["n_stressed_nodes"]
            equal += same and gap < 1e-3
            print(f"seed {seed} {case}: counts {theirs} equal {same}, lengths {gap:.1e} px apart")
    print(f"{equal} of {len(meshes) * len(cases)} cases equal")


def columns(network):
    x, y = (np.array(network["nodes"][axis]) for axis in "xy")
    part = network["segments"]
    return x, y, np.array(part["from"], int), np.array(part["to"], int), np.array(part["kind"])


def tips(network):
    """Ends of propagated segments, relative to the impact."""
    x, y, start, end, kind = columns(network)
    hit, own = network["impacts"][0], kind == "propagated"
    nodes = np.unique(np.r_[start[own], end[own]])
    return x[nodes] - hit["x"], y[nodes] - hit["y"]


def series(label, seeds, **keys):
    rows, stops = [], np.zeros(3, int)
    for seed in range(seeds):
        result, network = simulate(seed, **keys)
        report, summary = result["convergence"], result["summary"]
        if result["intact"]:
            rows.append([0.0] * 7)
            continue
        dx, dy = tips(network)
        x, y, start, end, kind = columns(network)
        length = np.hypot(x[end] - x[start], y[end] - y[start])
        reach = np.hypot(dx, dy).max(initial=0.0)
        rows.append([summary["n_radial"], report["n_fronts"] - 1, reach, summary["total_length"],
                     summary["n_segments"], length[kind == "mst"].sum(), report["n_steps"]])
        stops += [report[f"stopped_{why}"] for why in
                  ("below_threshold", "at_crack", "without_neighbor")]
    arms, hops, reach, length, segments, tree, steps = np.mean(rows, axis=0)
    print(f"{label:22} arms {arms:6.1f}  hops {hops:7.1f}  hops/arm {hops / max(arms, 1e-9):5.2f}  "
          f"reach {reach:4.0f} px  length {length:7.0f} px  tree {tree / max(length, 1e-9):.2f}  "
          f"segments {segments:6.0f}  steps {steps:5.1f}  stops {stops.tolist()}", flush=True)


def fan(seeds=20):
    for force in (310, 500, 1000):
        law = math.degrees(math.acos(THRESHOLD / force))
        for count in (10_000, 30_000):
            first, far = [], []
            for seed in range(seeds):
                _, network = simulate(seed, (683, 683), impact__0__direction_deg=0,
                                      impact__0__force=force, fracture__particles=count)
                dx, dy = tips(network)
                angle, r = np.degrees(np.abs(np.arctan2(dy, dx))), np.hypot(dx, dy)
                inside = np.maximum(np.abs(dx), np.abs(dy)) < 341 - RADIUS
                first.append(angle[(r > 0) & (r <= RADIUS)].max())
                far.append(angle[(r >= 200) & inside].max() - law)
            print(f"F {force:4} N {count}: arccos(T/F) {law:.2f}°, "
                  f"first ring {np.median(first):.2f}°, far field − law: "
                  f"median {np.median(far):+.2f}°, {min(far):+.2f} to {max(far):+.2f}", flush=True)


def literal(runs=150):
    """Independent meshes around the impact, at the density of the default."""
    rng = np.random.default_rng(1)
    for neighborhood in ("radius", "mesh-edges"):
        back, arms, hops = [], 0, 0
        for _ in range(runs if neighborhood == "radius" else 2 * runs):
            count = rng.poisson(1e4 / (FRAME[0] * FRAME[1]) * 450 * 450)
            points = np.r_[[[225, 225]], rng.random((count, 2)) * 450]
            angle = rng.random() * 2 * math.pi
            own = propagate(points, 0, (math.cos(angle), math.sin(angle)), rule="literal",
                            neighborhood=neighborhood, steps_back=back)
            arms += sum(hop[0] == 0 for hop in own["hops"])
            hops += len(own["hops"])
        backward = [parent for is_back, parent in back if is_back]
        print(f"{neighborhood}: {len(back)} steps, backward {len(backward) / len(back):.3f}, "
              f"of these to the parent {np.mean(backward):.3f}, hops per arm {hops / arms:.2f}")


def stress():
    _, network = simulate(7, impact__0__position="random")
    part = network["segments"]
    for kind in ("propagated", "mst"):
        values = [s for s, k in zip(part["stress_paper_units"], part["kind"]) if k == kind]
        print(f"{kind}: {len(values)} segments, stress {min(values):.0f} to {max(values):.0f}")


def loss(seeds):
    """Share of stress that a hop costs, 1 − cos θ, and the mesh it happens on."""
    for neighborhood in ("radius", "mesh-edges"):
        shares = []
        for seed in range(seeds):
            part = simulate(seed, fracture__neighbourhood=neighborhood)[1]["segments"]
            handed, kind = part["stress_paper_units"], part["kind"]
            shares += [1 - handed[i] / handed[p] for i, p in enumerate(part["parent"])
                       if p is not None and kind[i] == kind[p] == "propagated"
                       and handed[i] < handed[p]]
        print(f"{neighborhood}: loss per hop, median {np.median(shares):.1e}, over {len(shares)}")
    points = mesh_nodes(0, 10_000, "[0.5,0.5]")
    corners = points[Delaunay(points).simplices]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    a, b, c = np.sort(sides, axis=1).T
    smallest = np.degrees(np.arccos((b * b + c * c - a * a) / (2 * b * c)))
    around = cKDTree(points)
    inner = [p for p in points if 65 < p[0] < FRAME[0] - 65 and 65 < p[1] < FRAME[1] - 65]
    near = np.mean([len(around.query_ball_point(p, RADIUS)) - 1 for p in inner[:2000]])
    print(f"mesh: median edge {np.median(sides):.1f} px, smallest angle below 20° in "
          f"{(smallest < 20).mean():.0%} of the triangles; {near:.0f} nodes within {RADIUS:.0f} px")


def main():
    check = sys.argv[1] if len(sys.argv) > 1 else ""
    seeds = int(sys.argv[2]) if len(sys.argv) > 2 else 20
    if check == "reference":
        reference()
    elif check == "fan":
        fan(seeds)
    elif check == "literal":
        literal()
    elif check == "stress":
        stress()
    elif check == "loss":
        loss(seeds)
    elif check == "rules":
        series("default", seeds)
        for rule in ("caption", "literal"):
            series(rule, seeds, fracture__rule=rule)
        series("two_sided", seeds, fracture__two_sided="true")
        series("branches 2", seeds, fracture__branches=2)
        series("snap_to_mesh", seeds, fracture__snap_to_mesh="true")
        series("force 300", seeds, impact__0__force=300)
    elif check == "radius":
        for radius in (15, 30, 65):
            series(f"radius {radius}", seeds, fracture__neighbour_radius_px=radius)
        series("mesh-edges", seeds, fracture__neighbourhood="mesh-edges")
        series("mesh-edges two_sided", seeds, fracture__neighbourhood="mesh-edges",
               fracture__two_sided="true")
    elif check == "particles":
        for count in (1000, 10_000, 100_000):
            series(f"N {count}", seeds, fracture__particles=count)
        for count in (1000, 10_000, 100_000):
            series(f"N {count}, scaled R", seeds, fracture__particles=count,
                   fracture__neighbour_radius_px=RADIUS * math.sqrt(1e4 / count))
    else:
        sys.exit(__doc__)


main()
