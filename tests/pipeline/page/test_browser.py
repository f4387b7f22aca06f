"""The use of the page in a browser."""

import base64
import csv
import io
import json
import re
from pathlib import Path
from urllib.parse import unquote

import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

import pipeline
import tribo
from tests.helpers import page_sweeps as sweeps
from tests.helpers import synthetic
from tests.helpers.browser import absent, chromium
from tests.helpers.page_sweeps import column, same


@pytest.fixture(scope="module")
def browser():
    with chromium() as driver:
        yield driver


@pytest.fixture
def page(browser, tmp_path):
    """Function that opens the page of a sweep; errors and requests for files fail the test."""

    def opened(ds, **options):
        path = pipeline.explore(ds, tmp_path / "page.html", **options).path
        browser.get_log("performance")
        browser.get(path.as_uri())
        return browser

    yield opened
    assert browser.get_log("browser") == []
    messages = (json.loads(entry["message"]) for entry in browser.get_log("performance"))
    sent = [
        message["message"]["params"]["request"]["url"]
        for message in messages
        if message["message"]["method"] == "Network.requestWillBeSent"
    ]
    assert not [url for url in sent if url.startswith(("http:", "https:", "ws:", "wss:"))]


AXES = "load", "velocity"


def rows(link):
    text = unquote(link.removeprefix("data:text/csv;charset=utf-8,"))
    return list(csv.DictReader(io.StringIO(text)))


def critical_velocities(driver):
    link = driver.find_element(By.ID, "velocities-csv").get_attribute("href")
    return column(rows(link), "critical velocity [m/s]")


def test_a_page_begins_with_the_conditions_of_the_store_and_tells_messages_as_text(page):
    conditions = {
        "friction": 0.1012345678,
        "bulk_temperature": 311.987654,
        "critical_temperature": 421.123456,
        "unmodelled_rise": 0,
    }
    share = 0.0987654
    message = "<b>contact</b> touches </script> the edge & more"
    judged = tribo.Conditions(**conditions, criterion=tribo.Criterion(share=share))
    ds = sweeps.one(conditions=judged, status={})
    ds["message"][2, 3] = message
    driver = page(ds)
    initial = driver.execute_script("return chosen.conditions")
    assert initial == conditions | {"failing_share": share, "criterion": "share"}
    same(critical_velocities(driver), pipeline.boundary(ds)["critical_velocity"])
    driver.execute_script("choosePoint({ i: 2, j: 3 })")
    assert message in driver.find_element(By.ID, "point").text
    assert len(driver.find_elements(By.CSS_SELECTOR, "#diagram circle.ring")) == 1
    assert driver.find_element(By.ID, "sign-warned").is_displayed()


def test_what_is_typed_or_moved_changes_the_boundary_unless_it_cannot_be(page):
    driver = page(synthetic.sweep())
    before, unchanged = driver.execute_script("return chosen.conditions"), table(driver)
    field = typed(driver, "friction", "0.12")
    expected = synthetic.critical_velocity(750.0, synthetic.limit(friction=0.12))
    assert table(driver)[-1].startswith(f"750 {expected:.4g} ")
    driver.find_element(By.ID, "friction-range").send_keys(Keys.ARROW_RIGHT)
    assert field.get_attribute("value") == "0.121"
    driver.find_element(By.ID, "reset").click()
    assert field.get_attribute("value") == "0.1"
    for text in ("20", ""):
        field = typed(driver, "critical_temperature", text)
        assert field.get_attribute("aria-invalid") == "true"
        assert driver.find_element(By.ID, "critical_temperature-fault").text
    driver.find_element(By.ID, "reset").click()
    assert field.get_attribute("aria-invalid") == "false"
    assert table(driver) == unchanged
    field = driver.find_element(By.ID, "friction")
    typed(driver, "friction", "0,12")
    assert not driver.find_element(By.ID, "friction-fault").text
    assert driver.execute_script("return chosen.conditions") == before | {"friction": 0.12}
    field.send_keys("x" + Keys.ENTER)
    assert driver.find_element(By.ID, "friction-fault").text == "give a number such as 0.12"
    assert "are taken as exact" in driver.find_element(By.ID, "caveats").text
    assert driver.find_element(By.ID, "now").text.startswith("At friction 0.12, bulk temperature")
    typed(driver, "friction", "0.9")
    assert all(row.endswith("severe throughout") for row in table(driver))


def typed(driver, name, text):
    field = driver.find_element(By.ID, name)
    field.clear()
    field.send_keys(text + Keys.ENTER)
    return field


def table(driver):
    return [row.text for row in driver.find_elements(By.CSS_SELECTOR, "#velocities tbody tr")]


def test_points_are_reached_by_keyboard_and_show_their_fields(page):
    driver = page(synthetic.sweep(fields=True))
    (stop,) = driver.find_elements(By.CSS_SELECTOR, "#diagram [tabindex='0']")
    driver.execute_script("arguments[0].focus()", stop)
    tip = driver.find_element(By.ID, "tip")
    assert tip.get_attribute("role") == "status"  # so that it is read aloud
    i, j = len(synthetic.LOADS) // 2, len(synthetic.VELOCITIES) // 2
    assert tip.text.startswith(f"{synthetic.LOADS[i]:g} N, {synthetic.VELOCITIES[j]:g} m/s\nwear: ")
    stop.send_keys(Keys.ARROW_UP, Keys.ARROW_LEFT, Keys.ARROW_LEFT)
    name = f"{synthetic.LOADS[i + 1]:g} N, {synthetic.VELOCITIES[j - 2]:g} m/s"
    assert tip.text.startswith(f"{name}\nwear: ")
    stop.send_keys(Keys.ENTER)
    assert driver.find_element(By.CSS_SELECTOR, "#point h3").text == name
    assert driver.switch_to.active_element.get_attribute("aria-describedby") == "tip"
    place = [driver.find_element(By.ID, f"at-{axis}").get_attribute("value") for axis in AXES]
    assert [*map(float, place)] == [synthetic.LOADS[i + 1], synthetic.VELOCITIES[j - 2]]
    assert not driver.find_element(By.ID, "whole").is_displayed()
    driver.switch_to.active_element.send_keys("+")
    assert driver.find_element(By.ID, "whole").is_displayed()
    assert driver.switch_to.active_element.get_attribute("aria-describedby") == "tip"
    driver.find_element(By.ID, "whole").click()
    assert "max" not in driver.find_element(By.ID, "distribution-caption").text
    assert len(driver.find_elements(By.CSS_SELECTOR, "#distribution path.curve")) == 1
    drawn = """
    const done = arguments[arguments.length - 1];
    setTimeout(() => done([...document.querySelectorAll("#fields img")].map((each) => {
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = [each.naturalWidth, each.naturalHeight];
      const context = canvas.getContext("2d");
      context.drawImage(each, 0, 0);
      const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
      return [canvas.width, canvas.height, new Set(data).size];
    })), 300);
    """
    pictures = driver.execute_async_script(drawn)
    assert [size[:2] for size in pictures[::2]] == [[48, 36]] * 3
    assert all(colours > 20 for *_, colours in pictures)


DUTIES = {
    "load [N]": [250.0 + 20 * n for n in range(19)] + [5000.0],
    "velocity [m/s]": [0.6 + 0.1 * n for n in range(20)],
}


@pytest.mark.parametrize("width", [1300, 390])
def test_tables_fit_the_screen_light_and_dark(page, width):
    driver = page(synthetic.sweep(), points=DUTIES)
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    papers = set()
    for scheme in ("light", "dark"):
        feature = {"name": "prefers-color-scheme", "value": scheme}
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        body, *tables = driver.execute_script("""
        const wide = ["body", ".table"].flatMap((name) => [...document.querySelectorAll(name)]);
        return wide.map(({ scrollWidth, clientWidth }) => scrollWidth - clientWidth);
        """)
        assert (body, max(tables)) == (0, 0)
        (agrees,) = driver.execute_script("""
        const [last] = [...document.querySelectorAll(".wide")].slice(-1);
        return [last.querySelector("tbody tr").lastElementChild.getBoundingClientRect().right];
        """)
        assert agrees <= width
        papers.add(driver.execute_script("return getComputedStyle(document.body).backgroundColor"))
    driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    assert len(papers) == 2


AXE = Path(".venv/javascript/node_modules/axe-core/axe.min.js")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(page, scheme):
    if not AXE.exists():
        absent("no axe-core: make javascript installs it, where there is npm")
    driver = page(synthetic.sweep(fields=True), points=DUTIES)
    feature = {"name": "prefers-color-scheme", "value": scheme}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
    driver.execute_script("choosePoint({ i: 2, j: 3 })")
    typed(driver, "friction", "0.12")
    driver.execute_script(AXE.read_text())
    found = driver.execute_async_script("axe.run().then(arguments[arguments.length - 1])")
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    assert [(one["id"], one["nodes"][0]["html"]) for one in found["violations"]] == []
    assert len(found["passes"]) > 20


def test_a_page_prints_as_a_report_of_at_most_four_pages_with_20_duties(page):
    driver = page(synthetic.sweep(), points=DUTIES)
    size = {"preferCSSPageSize": True}
    printed = base64.b64decode(driver.execute_cdp_cmd("Page.printToPDF", size)["data"])
    assert 2 <= len(re.findall(rb"/Type /Page\b", printed)) <= 4
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    heads = [head.text for head in driver.find_elements(By.TAG_NAME, "h2") if head.is_displayed()]
    height = "return arguments[0].getBoundingClientRect().height"
    radius = driver.find_element(By.XPATH, "//td[.='pin.radius']")
    assert driver.execute_script(height, radius) > 0  # printed, even if closed on the screen
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    assert heads == [
        "Answer", "Operating points", "Transition diagram", "Conditions", "Critical velocities",
        "Critical loads", "Inputs", "Tests", "Origin",
    ]  # fmt: skip
