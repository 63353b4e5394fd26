#!/usr/bin/env python3
"""Sums up one run of the tests, from what `ctest --output-junit` wrote.

    deploy/report_tests.py FILE.xml PRESET

Prints the ten slowest tests, each skip with its reason, each failure with its first error and the command that
runs it alone, and "N passed, N failed, N skipped". Modules of Python's unittest and pytest are one test of
ctest each; what they skip inside is told here, too. Exits with 1 where no test ran.
"""
import os
import re
import sys
import xml.etree.ElementTree

REASON = re.compile(r"skipped ['\"](.*)['\"]|^SKIPPED \[\d+\] (.*)|: Skipped\n(.*)", re.MULTILINE)
FIRST_ERROR = re.compile(r"^.*(?:: Failure$|Error\b|ERROR|FAILED|\*\*\*|[Ee]xpected|: error:|terminate called).*$", re.MULTILINE)


def output_of(case):
    return case.findtext("system-out") or ""


def first_error(case):
    """The first line that tells of an error, and the two behind it."""
    output = output_of(case)
    found = FIRST_ERROR.search(output)
    if not found:
        return (case.find("failure") is not None and case.find("failure").get("message")) or "no output"
    return "\n    ".join(output[found.start():].splitlines()[:3])


def main(file, preset):
    if not os.path.exists(file):
        print("\nno test ran")
        return 1
    cases = list(xml.etree.ElementTree.parse(file).getroot().iter("testcase"))
    skipped = [case for case in cases if case.get("status") in ("notrun", "disabled")]
    failed = [case for case in cases if case.get("status") == "fail"]
    print("\nslowest tests:")
    for case in sorted(cases, key=lambda case: -float(case.get("time")))[:10]:
        print(f"{float(case.get('time')):7.1f} s  {case.get('name')}")
    for case in cases:
        reasons = {next(filter(None, found)) for found in REASON.findall(output_of(case)) if any(found)}
        for reason in sorted(reasons) or (["no reason told"] if case in skipped else []):
            print(f"skipped in {case.get('name')}: {reason}")
    for case in failed:
        name = case.get("name")
        print(f"\nFAILED {name}\n    {first_error(case)}\n"
              f"    alone: ctest --preset {preset} -R '^{re.escape(name)}$'")
    print(f"\n{len(cases) - len(skipped) - len(failed)} passed, {len(failed)} failed, {len(skipped)} skipped")
    return 0 if len(cases) > len(skipped) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
