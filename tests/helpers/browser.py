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
    """Skip a test for what is not installed, or fail it where CI says that it must be there."""
    (pytest.fail if os.environ.get("WITH_BROWSER") else pytest.skip)(reason)


@contextmanager
def chromium():
    """A driver of Chromium; skips where there is none, or fails where CI says there must be one."""
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
