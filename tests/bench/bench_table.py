"""What the benchmarks of the Python package share: measuring by turns, and a table with limits."""
import json
import pathlib
import statistics
import sys
import time

SLACK = .15  # by which --check lets a limit be missed, since others use the machine too


def seconds(work, clock=time.perf_counter):
    """Seconds of one call, by the wall clock unless told otherwise."""
    begin = clock()
    work()
    return clock() - begin


def medians(rounds, *works):
    """The median seconds of each, taken by turns after a call of each to warm up."""
    for work in works:
        work()
    taken = [[seconds(work) for work in works] for _ in range(rounds)]
    return [statistics.median(column) for column in zip(*taken)]


class Table:
    """Rows of a figure, its unit and its limit; printed as they come."""

    def __init__(self):
        self.rows = []

    def add(self, name, value, unit, at_most=None, at_least=None, of="", told=True):
        """A row. `of` says what it was made from; a row without limits only tells."""
        missed = (at_most is not None and not value <= at_most * (1 + SLACK)
                  or at_least is not None and not value >= at_least * (1 - SLACK))
        limit = (f"<= {at_most:g}" if at_most is not None
                 else f">= {at_least:g}" if at_least is not None else "")
        self.rows.append({"row": name, "value": value, "unit": unit, "at_most": at_most,
                          "at_least": at_least, "missed": missed, "of": of})
        if told:
            print(f"{name:<58} {value:8.3f} {unit:<7} {limit:<8} {of}{' MISSED' if missed else ''}",
                  flush=True)

    def finish(self, options):
        """Writes the rows where `--json` says; exits with 1 if `--check` finds one that is missed."""
        if options.json:
            rows = json.dumps({"rows": self.rows}, indent=1)
            pathlib.Path(options.json).write_text(rows + "\n")
        missed = [row["row"] for row in self.rows if row["missed"]]
        if missed and options.check:
            sys.exit(f"missed by more than {SLACK:.0%}: " + "; ".join(missed))


def add_options(parser, rounds):
    """Those that both have."""
    parser.add_argument("--rounds", type=int, default=rounds)
    parser.add_argument("--json", help="write the rows there")
    parser.add_argument("--tiny", action="store_true",
                        help="sizes that take seconds and whose figures mean nothing")
    parser.add_argument("--check", action="store_true",
                        help=f"exit with 1 where a limit is missed by more than {SLACK:.0%}")
