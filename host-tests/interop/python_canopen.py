"""Interoperation with python-canopen: as the drive of our client, and as the master of our simulated drive.

usage: python_canopen.py CANOPEN_BRIDGE
"""

import logging
import sys

from checks import Checks
from client import Client
from drive import Drive

# Fewer means that a part did not run.
LEAST_CHECKS = 60


def main(program):
    logging.disable(logging.WARNING)
    checks = Checks()
    for part in (Client, Drive):
        before = checks.passed
        part(program, checks).run()
        print(f"{part.__doc__}: {checks.passed - before} checks passed")
    total = checks.passed + checks.failed
    print(f"interop with python-canopen: {total} checks, {checks.failed} failed")
    if checks.failed or total < LEAST_CHECKS:
        sys.exit(1)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
