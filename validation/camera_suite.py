"""The camera suite on detectors: losses with intervals, and reversals of severity.

    python validation/camera_suite.py PROGRAM SOURCE STUDY [FIGURE.svg]

PROGRAM is the built `starbreak`; STUDY is the folder of

    starbreak study SOURCE --model … --suite camera --severities 1,2,3,4,5 --no-store --divergence off -o STUDY

Prints AP50 of whole images by preset and severity with the change from the clean images and its interval, mPC and rPC,
and the reversals: where AP50 is higher at the greater of two severities that follow each other, with the p of a paired
permutation test over images and the p after Holm's correction over the reversals alone, which is stricter than over all
pairs. Ends with 1 if one is below 0.05. Needs the standard library alone.
"""

import html
import json
import pathlib
import subprocess
import sys
import tempfile

REPLICATES = 4000


def of_all(study_or_evaluation, metric="ap50"):
    rows = study_or_evaluation["paired"]
    for row in rows:
        if (row["scope"]["kind"], row["group"]["kind"], row["metric"]) == ("whole_image", "all", metric):
            return row
    raise KeyError(metric)


def folder_name(condition):
    return f"{condition['family']}-severity-{condition['severity']}-seed-{condition['seed']}"


def compared(program, source, study, detector, pair):
    """Change of AP50 between two severities, and its p."""
    detections = [study / "detections" / detector / f"{folder_name(one)}.json" for one in pair]
    regions = study / "sets" / folder_name(pair[1]) / "starbreak" / "regions"
    with tempfile.TemporaryDirectory() as out:
        command = [program, "evaluate", source, "--clean", detections[0], "--damaged", detections[1], "--regions"]
        command += [regions, "--replicates", str(REPLICATES), "--quiet", "-o", pathlib.Path(out) / "report"]
        subprocess.run(command, check=True, stdout=subprocess.PIPE)
        text = (pathlib.Path(out) / "report" / "evaluation.json").read_text()
    row = of_all(json.loads(text)["evaluations"][0])
    return row["delta"]["value"], row.get("p")


def holm(tests):
    """Corrected p of tests [(name, p)], each at least the one before."""
    corrected, last = {}, 0.0
    for k, (name, p) in enumerate(sorted(tests, key=lambda it: it[1])):
        last = max(last, min(1.0, (len(tests) - k) * p))
        corrected[name] = last
    return corrected


def figure(path, curves, clean):
    """AP50 over severity: a small chart for each preset, both detectors in each."""
    presets = list(next(iter(curves.values())))
    n_columns, width, height, left, top = 5, 190, 150, 34, 26
    colors = ["#0b6", "#36c", "#c60"]
    n_rows = -(-len(presets) // n_columns)
    size = (n_columns * width + 10, n_rows * height + 34)
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size[0]} {size[1]}" font-family="sans-serif" '
        'font-size="10">',
        f'<rect width="{size[0]}" height="{size[1]}" fill="white"/>',
    ]
    for k, (detector, color) in enumerate(zip(curves, colors)):
        out.append(f'<text x="{10 + 130 * k}" y="18" fill="{color}" font-size="12">{html.escape(detector)}</text>')
    out.append('<text x="290" y="18">AP50 of whole images, %, over severity; dashed: clean; bars: 95 % of the change</text>')
    for place, preset in enumerate(presets):
        x0, y0 = (place % n_columns) * width + left, (place // n_columns) * height + top + 20
        w, h = width - left - 12, height - 46
        x = lambda severity: x0 + (severity - 0.5) / 5 * w  # noqa: E731
        y = lambda share: y0 + h * (1 - share / 0.6)  # noqa: E731
        out.append(f'<text x="{x0}" y="{y0 - 5}" font-size="11">{html.escape(preset)}</text>')
        for share in (0, 0.2, 0.4, 0.6):
            out.append(
                f'<path d="M{x0} {y(share):.1f}h{w}" stroke="#ddd"/>'
                f'<text x="{x0 - 4}" y="{y(share) + 3:.1f}" text-anchor="end">{100 * share:.0f}</text>'
            )
        for severity in range(1, 6):
            out.append(f'<text x="{x(severity):.1f}" y="{y0 + h + 12}" text-anchor="middle">{severity}</text>')
        for k, (detector, color) in enumerate(zip(curves, colors)):
            out.append(
                f'<path d="M{x0} {y(clean[detector]):.1f}h{w}" stroke="{color}" stroke-dasharray="3 3" stroke-width="0.8"/>'
            )
            points = curves[detector][preset]
            line = " ".join(f"{x(s) + 2 * k:.1f},{y(clean[detector] + d):.1f}" for s, d, _, _ in points)
            out.append(f'<polyline points="{line}" fill="none" stroke="{color}" stroke-width="1.4"/>')
            for s, _, low, high in points:
                ends = [y(max(0.0, clean[detector] + end)) for end in (low, high)]
                out.append(f'<path d="M{x(s) + 2 * k:.1f} {ends[0]:.1f}V{ends[1]:.1f}" stroke="{color}" stroke-width="0.9"/>')
    pathlib.Path(path).write_text("\n".join(out + ["</svg>"]) + "\n")


def main():
    program, source, study = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
    result = json.loads((study / "evaluation.json").read_text())
    curves, clean, by_name = {}, {}, {}
    for one in result["evaluations"]:
        row, condition, detector = of_all(one), one["condition"], one["detector"]
        clean[detector] = row["clean"]["value"]
        change = row["delta"]
        low, high = (change["value"] if change.get(end) is None else change[end] for end in ("low", "high"))
        point = (condition["severity"], change["value"], low, high)
        curves.setdefault(detector, {}).setdefault(condition["family"], []).append(point)
        by_name[detector, condition["family"], condition["severity"]] = condition
    tests = []
    for detector, families in curves.items():
        severities = ", ".join(str(point[0]) for point in next(iter(families.values())))
        print(f"{detector}: AP50 of clean images {100 * clean[detector]:.1f} %; points of it at severity {severities} [95 %]")
        for family, points in families.items():
            cells = "  ".join(f"{100 * d:6.1f} [{100 * low:5.1f}, {100 * high:5.1f}]" for _, d, low, high in points)
            print(f"  {family:27} {cells}")
            for before, after in zip(points, points[1:]):
                if after[1] > before[1]:
                    pair = [by_name[detector, family, one[0]] for one in (before, after)]
                    delta, p = compared(program, source, study, detector, pair)
                    tests.append((f"{detector}, {family}, {before[0]} to {after[0]}", delta, 1.0 if p is None else p))
        for row in result["robustness"]:
            if row["detector"] == detector and row["metric"] in ("ap", "ap50") and row["scope"]["kind"] == "whole_image":
                mpc, rpc = row["mpc"], row["rpc"]
                ends = lambda it: f" [{100 * it['low']:.1f}, {100 * it['high']:.1f}]" if it.get("low") is not None else ""  # noqa: E731
                print(f"  {row['metric']}: mPC {100 * mpc['value']:.1f}{ends(mpc)} %, rPC {100 * rpc['value']:.1f}{ends(rpc)} %")
        print()
    corrected = holm([(name, p) for name, _, p in tests])
    n_pairs = sum(len(points) - 1 for families in curves.values() for points in families.values())
    print(f"{len(tests)} of {n_pairs} steps of severity raise AP50; points, p, p after Holm over these:")
    for name, delta, p in sorted(tests, key=lambda it: it[2]):
        print(f"  {name:44} {100 * delta:5.2f}  {p:.4f}  {corrected[name]:.3f}")
    n_significant = sum(p < 0.05 for p in corrected.values())
    print(f"{n_significant} of them significant")
    if len(sys.argv) > 4:
        figure(sys.argv[4], curves, clean)
    return 1 if n_significant else 0


if __name__ == "__main__":
    sys.exit(main())
