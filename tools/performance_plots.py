"""The pictures of docs/performance.md, drawn by tools/performance from the rows of `rve-farm bench --json` and of compare-peers."""
from statistics import median

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

plt.rcParams.update({"savefig.dpi": 130, "font.size": 10, "axes.grid": True, "grid.alpha": 0.3, "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})


def plot_rves(rows, path):
    figure, axis = plt.subplots(figsize=(6.0, 3.8), constrained_layout=True)
    count = [r["rves"] for r in rows]
    for part, label in (("us_per_substep", "whole loop"), ("us_per_substep_inner", "inner loop")):
        line, = axis.loglog(count, [r[part]["median"] for r in rows], "o-", label=f"{label}, median")
        axis.loglog(count, [r[part]["min"] for r in rows], "v:", color=line.get_color(), ms=4, label=f"{label}, minimum")
    axis.set(xlabel="RVEs on one thread", ylabel="µs per RVE and sub-step", ylim=(0.3, 30), title="Cost linear in the RVEs is a flat line")
    axis.legend(fontsize=8, ncol=2)
    figure.savefig(path)
    plt.close(figure)


def plot_levels(rows, path):
    figure, axis = plt.subplots(figsize=(6.4, 3.8), constrained_layout=True)
    for offset, precision in ((-0.2, "single"), (0.2, "double")):
        own = [r for r in rows if r["precision"] == precision]
        whole, inner = [r["us_per_substep"]["median"] for r in own], [r["us_per_substep_inner"]["median"] for r in own]
        place = [k + offset for k in range(len(own))]
        bars = axis.bar(place, whole, 0.36, alpha=0.4, label=f"{precision}, whole loop")
        axis.bar(place, inner, 0.36, color=bars[0].get_facecolor()[:3], label=f"{precision}, of it inner loop")
        for x, value in zip(place, whole):
            axis.text(x, value, f"{value:.1f}", ha="center", va="bottom", fontsize=8)
    axis.set_xticks(range(len(own)), [r["simd"] for r in own])
    axis.set(ylabel="µs per sub-step (median)", title="400 discs, one thread, every instruction level")
    axis.legend(fontsize=8)
    figure.savefig(path)
    plt.close(figure)


def plot_peers(compared, path):
    figure, axis = plt.subplots(figsize=(6.8, 3.2), constrained_layout=True)
    names = list(compared["times"])[::-1]
    for k, name in enumerate(names):
        seen, colour = compared["times"][name], "tab:grey" if name in compared["peers"] else "tab:blue"
        axis.plot(seen, [k] * len(seen), "|", color=colour, ms=10)
        axis.plot(median(seen), k, "o", color=colour)
        axis.text(1.15 * max(seen), k, f"{median(seen):.3g}", va="center", fontsize=9)
    axis.set_yticks(range(len(names)), names)
    axis.set_xscale("log")
    axis.set_xlim(1, 2 * max(max(seen) for seen in compared["times"].values()))
    axis.set(ylim=(-0.6, len(names) - 0.4), xlabel="µs per sub-step, 400 discs, one thread (dot: median; ticks: each round)")
    figure.savefig(path)
    plt.close(figure)
