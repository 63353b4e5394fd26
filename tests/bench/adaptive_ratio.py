#!/usr/bin/env python3
"""What adaptive sampling takes to an error, over what as many samples everywhere take to the same.

    tessera bench error SCENE... --methods owen owen+adaptive --samples 16-256 --json FILE ...
    tests/bench/adaptive_ratio.py FILE [FILE...]        of equal rows the last file's count

Of each row of an adaptive method: its samples, its root mean square error, and the samples and
seconds that the method of the same words without `adaptive` takes to that error, read off the line
between its two neighbours, all axes logarithmic."""
import json
import math
import sys


def at(curve, error):
    """On the line through the neighbours of an error, or the nearest two."""
    curve = sorted(curve, reverse=True)
    pairs = list(zip(curve, curve[1:]))
    for (e0, v0), (e1, v1) in pairs:
        if e1 <= error or (e1, v1) == pairs[-1][1]:
            share = math.log(error / e0) / math.log(e1 / e0)
            return math.exp(math.log(v0) + share * math.log(v1 / v0))
    raise SystemExit("expected two rows of the uniform method")


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    print(f"{'scene':18} {'samples':>8} {'rmse':>9} {'of samples':>11} {'of seconds':>11}")
    found = {}
    for path in sys.argv[1:]:
        with open(path, encoding="utf-8") as file:
            for row in json.load(file)["rows"]:
                found[row["scene"], row["method"], row["samples"]] = row
    rows = list(found.values())
    for row in rows:
        words = row["method"].split("+")
        if "adaptive" not in words:
            continue
        words.remove("adaptive")
        plain = [other for other in rows if other["scene"] == row["scene"]
                 and sorted(other["method"].split("+")) == sorted(words)]
        ratios = [row[key] / at([(p["rmse"], p[key]) for p in plain], row["rmse"])
                  for key in ("samples", "seconds")]
        print(f"{row['scene']:18} {row['samples']:8.1f} {row['rmse']:9.5f} {ratios[0]:11.2f} "
              f"{ratios[1]:11.2f}")


if __name__ == "__main__":
    main()
