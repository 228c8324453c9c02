"""Known answers for the statistics, from programs that we did not write.

Needs numpy, scipy, statsmodels, lifelines and tidecv (which needs pycocotools and
opencv-python-headless), from PyPI:
    python crates/eval/tests/statistics/known_answers.py
writes known_answers.json beside itself; the versions used are in it. Seeded; run again, it writes
the same.
"""
import importlib.metadata
import json
import pathlib
import warnings

import numpy as np
import scipy.stats as st
import statsmodels.api as sm
from lifelines import KaplanMeierFitter
from lifelines.utils import median_survival_times
from statsmodels.stats.contingency_tables import mcnemar
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.proportion import proportion_confint
from tidecv import TIDE, Data

warnings.simplefilter("ignore")
rng = np.random.default_rng(20)


def num(x):
    x = float(x)
    return x if np.isfinite(x) else None


def wilson():
    cases = [(0, 1), (1, 1), (0, 10), (3, 10), (159, 326), (6, 56), (5000, 35871)]
    out = []
    for k, n in cases:
        for level in (0.9, 0.95, 0.99):
            low, high = proportion_confint(k, n, alpha=1 - level, method="wilson")
            out.append(dict(k=k, n=n, level=level, low=num(low), high=num(high)))
    return out


def mcnemars():
    out = []
    for b, c in [(0, 1), (1, 0), (5, 5), (3, 11), (159, 2), (40, 60), (512, 440), (9000, 9300)]:
        p = mcnemar([[0, b], [c, 0]], exact=True).pvalue
        n = b + c
        point = st.binom.pmf(b, n, 0.5)
        mid = 1 - point / 2 if b == c else 2 * st.binom.cdf(min(b, c), n, 0.5) - point
        out.append(dict(b=b, c=c, exact=num(p), mid_p=num(mid)))
    return out


def holms():
    out = []
    for n in (1, 3, 8, 20):
        p = np.round(rng.uniform(0, 0.2, n) ** 2, 6)
        p[-1] = p[0]
        out.append(dict(p=p.tolist(), corrected=multipletests(p, method="holm")[1].tolist()))
    return out


def logistics():
    out = []
    for n, slope, n_clusters in ((60, 2.0, 20), (400, 6.0, 80), (300, -0.02, 60)):
        scale = 50.0 if abs(slope) < 1 else 1.0
        x = np.round(rng.uniform(0, scale, n), 5)
        clusters = rng.integers(0, n_clusters, n)
        shared = rng.normal(0, 0.7, n_clusters)[clusters]
        y = (rng.uniform(size=n) < 1 / (1 + np.exp(-(-1 + slope * x + shared)))).astype(int)
        fit = sm.Logit(y, sm.add_constant(x)).fit(disp=0, tol=1e-14, maxiter=200)
        cluster = sm.Logit(y, sm.add_constant(x)).fit(
            disp=0, tol=1e-14, maxiter=200, cov_type="cluster", cov_kwds=dict(groups=clusters))
        u = st.mannwhitneyu(x[y == 1], x[y == 0]).statistic
        low, high = cluster.conf_int()[1]
        out.append(dict(
            dose=x.tolist(), failed=y.tolist(), clusters=clusters.tolist(),
            beta=fit.params.tolist(), se=fit.bse.tolist(), se_clustered=cluster.bse.tolist(),
            p=cluster.pvalues.tolist(), slope_interval=[low, high],
            auc=num(u / ((y == 1).sum() * (y == 0).sum()))))
    return out


def bootstraps():
    out = []
    for n, seed in ((12, 1), (40, 2)):
        data = np.round(np.random.default_rng(seed).lognormal(0, 1, n), 6)
        first = st.bootstrap((data,), np.mean, n_resamples=500, method="percentile",
                             rng=np.random.default_rng(3))
        found = first.confidence_interval
        out.append(dict(replicates=first.bootstrap_distribution.tolist(),
                        percentile=[float(found.low), float(found.high)]))
    return out


def survivals():
    out = []
    # The last is looked at for so short a time that the median's interval has no upper end.
    for n, share, draw in ((8, 0.7, rng), (30, 0.7, rng), (20, 0.45, np.random.default_rng(22))):
        t = np.round(draw.exponential(2.0, n), 1) + 0.1
        failed = draw.uniform(size=n) < share
        km = KaplanMeierFitter().fit(t, failed)
        times = km.event_table.index[km.event_table.observed > 0]
        ci = km.confidence_interval_
        rows = [dict(time=num(x), at_risk=int(km.event_table.at_risk[x]),
                     survival=num(km.survival_function_.loc[x].iloc[0]),
                     low=num(ci.loc[x].iloc[0]), high=num(ci.loc[x].iloc[1])) for x in times]
        ends = median_survival_times(ci).iloc[0]
        out.append(dict(times=t.tolist(), failed=failed.tolist(), rows=rows,
                        median=num(km.median_survival_time_), median_low=num(ends.iloc[0]),
                        median_high=num(ends.iloc[1])))
    return out


def tide_case(n_images, n_classes, seed, ties):
    r = np.random.default_rng(seed)
    gt, dt = Data("gt"), Data("dt")
    objects, detections = [], []
    for c in range(n_classes):
        gt.add_class(c, str(c))
    for i in range(n_images):
        gt.add_image(i, str(i))
        dt.add_image(i, str(i))
        for _ in range(r.integers(0, 7)):
            box = np.round(np.concatenate([r.uniform(0, 200, 2), r.uniform(5, 90, 2)]), 1).tolist()
            c = int(r.integers(0, n_classes))
            crowd = bool(r.uniform() < 0.12)
            objects.append([i, c, box, crowd])
            (gt.add_ignore_region if crowd else gt.add_ground_truth)(i, c, box)
            for _ in range(r.integers(0, 4)):
                shift = r.normal(0, r.choice([0.03, 0.2, 0.5]), 4) * [box[2], box[3], box[2], box[3]]
                d = np.round(np.array(box) + shift, 1)
                d[2:] = np.maximum(d[2:], 1)
                dc = c if r.uniform() < 0.75 else int(r.integers(0, n_classes))
                detections.append([i, dc, d.tolist(), float(np.round(r.uniform(), 1 if ties else 6))])
        for _ in range(r.integers(0, 3)):
            box = np.round(np.concatenate([r.uniform(0, 200, 2), r.uniform(5, 90, 2)]), 1).tolist()
            detections.append([i, int(r.integers(0, n_classes)), box,
                               float(np.round(r.uniform(), 1 if ties else 6))])
    for i, c, box, score in detections:
        dt.add_detection(i, c, score, box)
    run = TIDE().evaluate(gt, dt, mode=TIDE.BOX)
    main = run.fix_main_errors()
    special = run.fix_special_errors()
    counts = run.count_errors()
    return dict(
        n_images=n_images, n_classes=n_classes, objects=objects, detections=detections,
        ap=num(run.ap), d_ap={k.short_name: num(v) for k, v in main.items()},
        n={k.short_name: v for k, v in counts.items()},
        special={k.short_name: num(v) for k, v in special.items()})


def main():
    names = ("numpy", "scipy", "statsmodels", "lifelines", "tidecv", "pycocotools")
    answers = dict(
        versions={name: importlib.metadata.version(name) for name in names},
        wilson=wilson(), mcnemar=mcnemars(), holm=holms(),
        logistic=logistics(), bootstrap=bootstraps(), survival=survivals(),
        tide=[tide_case(*case) for case in
              ((1, 1, 1, False), (6, 2, 2, False), (12, 4, 3, False), (12, 3, 4, True),
               (40, 5, 5, False), (3, 6, 6, True))])
    path = pathlib.Path(__file__).with_suffix(".json")
    path.write_text(json.dumps(answers, separators=(",", ":")).replace('"},', '"},\n') + "\n")
    print(path.name, path.stat().st_size, "bytes")


if __name__ == "__main__":
    main()
