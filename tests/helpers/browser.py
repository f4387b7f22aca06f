"""A browser without a screen, for pages: Debian's Chromium, driven by Selenium."""

import os
import shutil
import tempfile
from contextlib import contextmanager

import pytest

_OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1280,1000",
)


def absent(reason):
    """Skip a test that lacks a program, with the reason; with WITH_BROWSER, as in CI, fail it."""
    (pytest.fail if os.environ.get("WITH_BROWSER") else pytest.skip)(reason)


@contextmanager
def chromium():
    """Context: a Selenium driver of Chromium; if it is not installed, see `absent`."""
    browser, program = shutil.which("chromium"), shutil.which("chromedriver")
    if not (browser and program):
        absent("no chromium and chromedriver: apt-get install chromium chromium-driver")
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = browser
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    for option in _OPTIONS:
        options.add_argument(option)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        options.add_argument(f"--user-data-dir={folder}")
        service = webdriver.ChromeService(program)
        with webdriver.Chrome(options=options, service=service) as driver:
            yield driver
