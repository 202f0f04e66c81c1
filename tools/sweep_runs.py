#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What tools/measure-sweeps keeps: reads it, for tools/plot-sweeps too, and prints it as tables in Markdown.

tools/sweep_runs.py FOLDER, which is out/sweeps/NAME
"""
import json
import pathlib
import sys

METRICS = ("directions", "printed")
USUAL_PIECES = 60  # of the scene's diameter, a cell's size; these two are what is not varied
USUAL_REFERENCES = 16


def read(folder):
    """(sweep, runs): the settings of all runs, and a dictionary of settings and figures for each that was scored."""
    folder = pathlib.Path(folder)
    if not (folder / "sweep.json").is_file():
        sys.exit(f"{folder}: there is no sweep.json here; it must be a folder that tools/measure-sweeps made")
    runs = [run_in(scores.parent) for scores in sorted(folder.glob("*/scores.json"))]
    if not runs:
        sys.exit(f"{folder}: no run was finished here")
    return json.loads((folder / "sweep.json").read_text()), runs


def run_in(folder):
    settings, build, scores = (json.loads((folder / f"{name}.json").read_text())
                               for name in ("settings", "build", "scores"))
    store = scores["methods"]["store"]
    per_view = build["time_ms"]["per_view"]
    return settings | {
        "psnr": store["raw"]["psnr"],
        "mssim": store["raw"]["ssim"],
        "textured": store["textured"],
        "cells": build["cells"],
        "all_references": build["references"],
        "stored": build["views"]["stored"],
        "planning_ms": per_view["visibility"]["median"] + per_view["plan"]["median"],
    }


def of_cell_size(sweep, runs, metric, partition):
    """By number of cells."""
    return sorted((run for run in runs if run["metric"] == metric and run["partition"] == partition
                   and run["references"] == USUAL_REFERENCES and run["views"] == sweep["views"]),
                  key=lambda run: run["pieces"])


def of_references(runs, metric, views):
    return sorted((run for run in with_usual_cells(runs, metric) if run["views"] == views),
                  key=lambda run: run["references"])


def of_views(runs, metric):
    return sorted((run for run in with_usual_cells(runs, metric) if run["references"] == USUAL_REFERENCES),
                  key=lambda run: run["views"])


def with_usual_cells(runs, metric):
    return [run for run in runs
            if run["metric"] == metric and run["partition"] == "clusters" and run["pieces"] == USUAL_PIECES]


COLUMNS = ("PSNR, dB", "MSSIM", "textured, %", "cells", "references", "views stored", "planning, ms")


def figures(run):
    return (f"{run['psnr']:.2f}", f"{run['mssim']:.4f}", f"{100 * run['textured']:.1f}", str(run["cells"]),
            str(run["all_references"]), str(run["stored"]), f"{run['planning_ms']:.1f}")


def print_table(title, varied, rows):
    """rows: (what was varied, metric, run)."""
    print(f"\n**{title}**\n")
    print("| " + " | ".join((varied, "metric", *COLUMNS)) + " |")
    print("|---" * (2 + len(COLUMNS)) + "|")
    for value, metric, run in rows:
        print("| " + " | ".join((value, metric, *figures(run))) + " |")


def main(folder):
    sweep, runs = read(folder)
    print_table("Cell size", "cells", [
        (f"{partition}, 1/{run['pieces']}" if partition == "clusters" else f"{partition}, as many", metric, run)
        for metric in METRICS
        for run in sorted(of_cell_size(sweep, runs, metric, "clusters") + of_cell_size(sweep, runs, metric, "grid"),
                          key=lambda run: (run["pieces"], run["partition"]))
        for partition in [run["partition"]]])
    for views in (sweep["views"], sweep["offered"]):
        print_table(f"References, at most {views} views", "references a cell", [
            (str(run["references"]), metric, run) for metric in METRICS for run in of_references(runs, metric, views)])
    print_table("Views", f"views of {sweep['offered']}", [
        (str(run["views"]), metric, run) for metric in METRICS for run in of_views(runs, metric)])


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: tools/sweep_runs.py out/sweeps/NAME")
    main(sys.argv[1])
