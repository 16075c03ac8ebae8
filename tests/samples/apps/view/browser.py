"""gicube-view's page as a person has it before him: what is on it, and what hands do."""

from __future__ import annotations

import base64
import os
import pathlib
import shlex
import subprocess
import time
from typing import Any, Callable

import numpy as np
import OpenImageIO as oiio
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement
from selenium.webdriver.support.ui import Select
from view_program import BIN, Program

# With a folder in GICUBE_VIEW_PICTURES, tests leave screenshots there.
FOLDER = os.environ.get("GICUBE_VIEW_PICTURES")

# Opaque, so that a canvas keeps each bit.
LOOK = ("--fix", "size=128x128", "--fix", "background=0.1,0.2,0.3")

DROP = """
const [name, text, done] = arguments;
const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
const data = new DataTransfer();
data.items.add(new File([bytes], name));
for (const kind of ["dragenter", "dragover", "drop"]) document.body.dispatchEvent(
    new DragEvent(kind, {dataTransfer: data, bubbles: true, cancelable: true}));
done();
"""


def wait(what: str, holds: Callable[[], Any], seconds: float = 60) -> Any:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := holds():
            return found
        time.sleep(0.02)
    raise AssertionError(f"waited {seconds} s for {what}")


class Shown:
    """The page in one tab of the browser."""

    def __init__(self, browser: webdriver.Chrome, program: Program, address: str = "") -> None:
        self.browser, self.program = browser, program
        browser.set_window_size(1280, 720)
        browser.get("about:blank")
        browser.get(address or program.address)

    def find(self, selector: str) -> WebElement:
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def text(self, selector: str) -> str:
        return str(self.browser.execute_script("return document.querySelector(arguments[0])?.textContent ?? ''",
                                               selector))

    def settled(self) -> str | None:
        """Waits until no picture is under way; the number of the one that is shown."""
        canvas = self.find("#picture")
        wait("the answer to the last request", lambda: canvas.get_attribute("aria-busy") == "false")
        return canvas.get_attribute("data-id")

    def picture(self) -> np.ndarray[Any, Any]:
        """The canvas's pixels, once it shows the whole picture of the view as it is."""
        self.settled()
        wait("a whole picture", lambda: self.find("#picture").get_attribute("data-final") == "true")
        return self.pixels("#picture")

    def pixels(self, selector: str) -> np.ndarray[Any, Any]:
        width, height, data = self.browser.execute_script(
            "const c = document.querySelector(arguments[0]);"
            "return [c.width, c.height, Array.from(c.getContext('2d').getImageData(0, 0, c.width, c.height).data)]",
            selector,
        )
        return np.array(data, dtype="u1").reshape(height, width, 4)

    def after(self, act: Callable[[], Any]) -> np.ndarray[Any, Any]:
        """The whole picture that follows an act."""
        before = self.settled()
        act()
        wait("another picture", lambda: self.find("#picture").get_attribute("data-id") != before)
        return self.picture()

    def put(self, field: str, value: str) -> None:
        """Into a field, as by typing."""
        element = self.find(f"#set-{field}".replace(".", "\\."))
        self.browser.execute_script("arguments[0].closest('details')?.setAttribute('open', '')", element)
        if element.tag_name == "select":
            Select(element).select_by_value(value)
        else:
            element.send_keys(Keys.CONTROL + "a" + Keys.NULL + value + Keys.TAB)

    def drop(self, name: str, content: bytes) -> None:
        self.browser.execute_async_script(DROP, name, base64.b64encode(content).decode())

    def shot(self, size: tuple[int, int], dark: bool, act: Callable[[], object], name: str) -> None:
        """Acts on a screen of that size; a screenshot of it is kept if somebody asks for those."""
        metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        feature = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
        try:
            act()
            if FOLDER:
                self.browser.save_screenshot(str(pathlib.Path(FOLDER) / name))
        finally:
            self.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
            self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})

    def faults(self) -> list[str]:
        """What the browser complains about, as of scripts and of the content security policy."""
        return [line["message"] for line in self.browser.get_log("browser") if line["level"] == "SEVERE"]


def run(command: str, folder: pathlib.Path) -> None:
    words = shlex.split(command)
    subprocess.run([str(BIN / words[0]), *words[1:], "--quiet"], cwd=folder, check=True, timeout=120)


def png(path: pathlib.Path) -> np.ndarray[Any, Any]:
    return np.asarray(oiio.ImageBuf(str(path)).get_pixels(oiio.UINT8))
