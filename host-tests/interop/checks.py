"""Counted checks: each says what it expected and got, and none ends the run."""

import time

from bridge import PATIENCE_S


class Checks:
    def __init__(self):
        self.passed = 0
        self.failed = 0

    def same(self, what, expected, actual):
        if expected == actual:
            self.passed += 1
        else:
            self.failed += 1
            print(f"FAILED {what}: expected {expected!r}, got {actual!r}")

    def near(self, what, expected, actual, tolerance):
        self.same(f"{what} ({actual} within {tolerance} of {expected})", True, abs(actual - expected) <= tolerance)

    def becomes(self, what, expected, read):
        """Waits until a value is what it shall be."""
        deadline = time.monotonic() + PATIENCE_S
        while (actual := read()) != expected and time.monotonic() < deadline:
            time.sleep(0.01)
        self.same(what, expected, actual)

    def raises(self, what, error, code, action):
        try:
            actual = f"no error, {action()!r}"
        except error as raised:
            actual = raised.code
        self.same(what, code, actual)
