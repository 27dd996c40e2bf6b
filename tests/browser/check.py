#!/usr/bin/env python3
"""Opens pages of `contact-patch report` in a headless Chromium and looks at them as a reader would.

    tests/browser/check.py [--shots DIRECTORY] PAGE.html...

Needs Python 3.10 and a Chromium (CHROMIUM, else chromium or google-chrome on the path); nothing else. At 1200 and 400 pixels,
in light and in dark:

 - no two texts overlap, none is cut at the edge of its picture, nothing scrolls sideways;
 - text of pictures is at least 11 pixels high, and stands out from what is behind it (contrast 4.5 of WCAG 2);
 - the answer and the main picture are on the first screen;
 - hover says x, y, pressure and gap, and at the peak the peak; the surface is drawn and turns; a dragged line gives a section;
 - nothing is written to the console as an error, and no request leaves the page;
 - without scripts the picture and the tables are there;
 - on paper the picture is on the first page, and the scene is unfolded.

Exit code 0 when all hold; 1 with a line for each that does not.
"""

import argparse
import base64
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# Width and height of a window, pixels.
SCREENS = [(1200, 800), (400, 860)]
# What fits on A4 within the margins of the page, pixels.
PAPER = (688, 1009)
# Least height of text in pictures, pixels.
SMALLEST = 11.0


class Browser:
    """A headless Chromium, spoken to over a pair of pipes (--remote-debugging-pipe: JSON, ended by a zero byte)."""

    def __init__(self) -> None:
        program = os.environ.get("CHROMIUM") or next(
            filter(None, map(shutil.which, ["chromium", "chromium-headless-shell", "chromium-browser", "google-chrome"])), None)
        if program is None:
            sys.exit("no Chromium: install the package chromium, or name one in CHROMIUM")
        # Its helpers may still write there when it has ended.
        self.home = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        to_read, self.write = os.pipe()
        self.read, to_write = os.pipe()
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
                   "--remote-debugging-pipe", f"--user-data-dir={self.home.name}", "--hide-scrollbars", "about:blank"]
        # The browser reads from 3 and writes to 4, whatever numbers the pipes have here.
        command = ["sh", "-c", 'exec 7<&"$0" 8>&"$1"; shift; exec 3<&7 4>&8 7<&- 8>&-; exec "$@"',
                   str(to_read), str(to_write), program, *options]
        self.process = subprocess.Popen(command, pass_fds=[to_read, to_write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_read)
        os.close(to_write)
        self.number, self.rest, self.events = 0, b"", []
        self.session = None
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ["Page", "Runtime", "Log", "Network"]:
            self.ask(domain + ".enable")

    def close(self) -> None:
        self.process.terminate()
        self.process.wait(timeout=20)
        os.close(self.write)
        os.close(self.read)
        self.home.cleanup()

    def message(self) -> dict:
        while b"\0" not in self.rest:
            piece = os.read(self.read, 1 << 20)
            if not piece:
                sys.exit("the browser has ended")
            self.rest += piece
        text, self.rest = self.rest.split(b"\0", 1)
        return json.loads(text)

    def ask(self, method: str, **parameters) -> dict:
        self.number += 1
        request = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            request["sessionId"] = self.session
        os.write(self.write, json.dumps(request).encode() + b"\0")
        while True:
            answer = self.message()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self.events.append(answer)

    def wait_for(self, event: str) -> None:
        while not any(e.get("method") == event for e in self.events):
            self.events.append(self.message())

    def run(self, code: str):
        answer = self.ask("Runtime.evaluate", expression=code, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(json.dumps(answer["exceptionDetails"])[:800])
        return answer["result"].get("value")

    def open(self, page: Path, width: int, height: int, scheme: str, media: str = "screen") -> None:
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        self.ask("Emulation.setEmulatedMedia", media=media, features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.events.clear()
        self.ask("Page.navigate", url=page.resolve().as_uri())
        self.wait_for("Page.loadEventFired")

    def mouse(self, kind: str, x: float, y: float, held: bool = False) -> None:
        button = {"button": "left", "buttons": 1 if held else 0, "clickCount": 1} if kind != "mouseMoved" or held else {}
        self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, **button)

    def drag(self, start, end) -> None:
        self.mouse("mouseMoved", *start)
        self.mouse("mousePressed", *start, held=True)
        for k in range(1, 5):
            self.mouse("mouseMoved", *(a + (b - a) * k / 4 for a, b in zip(start, end)), held=True)
        self.mouse("mouseReleased", *end)

    def shot(self, file: Path) -> None:
        file.write_bytes(base64.b64decode(self.ask("Page.captureScreenshot", format="png", captureBeyondViewport=True)["data"]))


# Every text that is seen, with its box, and everything that is wrong with it by itself.
TEXTS = """(() => {
  const wrong = [], boxes = [];
  const linear = (c) => { c /= 255; return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; };
  const light = (text) => { const [r, g, b] = text.match(/[\\d.]+/g).map(Number); return 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b); };
  const contrast = (a, b) => { const [low, high] = [light(a), light(b)].sort((p, q) => p - q); return (high + 0.05) / (low + 0.05); };
  const behind = (node) => {
    for (let e = node; e; e = e.parentElement) {
      const colour = getComputedStyle(e).backgroundColor;
      if (colour && !/, 0\\)$|transparent/.test(colour)) return colour;
    }
    return "rgb(255, 255, 255)";
  };
  const seen = (e) => e.checkVisibility && e.checkVisibility({visibilityProperty: true}) && e.getBoundingClientRect().width > 0;
  const brief = (text) => JSON.stringify(text.trim().slice(0, 40));
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walk.nextNode(); node; node = walk.nextNode()) {
    const parent = node.parentElement;
    if (!node.textContent.trim() || parent.closest("script, style") || !seen(parent)) continue;
    const svg = parent.closest("svg"), style = getComputedStyle(parent);
    if (svg) {
      const ctm = parent.getScreenCTM(), size = parseFloat(style.fontSize) * Math.hypot(ctm.a, ctm.b);
      if (size < SMALLEST - 0.05) wrong.push(`${brief(node.textContent)} is ${size.toFixed(1)} px high`);
      if (contrast(style.fill, behind(svg)) < 4.5) wrong.push(`${brief(node.textContent)} in ${style.fill} on ${behind(svg)} cannot be read`);
      const box = parent.getBoundingClientRect(), around = svg.getBoundingClientRect();
      if (box.left < around.left - 1 || box.right > around.right + 1 || box.top < around.top - 1 || box.bottom > around.bottom + 1)
        wrong.push(`${brief(node.textContent)} is cut at the edge of its picture`);
      boxes.push([box.left, box.top, box.right, box.bottom, brief(node.textContent)]);
    } else {
      if (contrast(style.color, behind(parent)) < 4.5) wrong.push(`${brief(node.textContent)} in ${style.color} on ${behind(parent)} cannot be read`);
      const range = document.createRange();
      range.selectNodeContents(node);
      const scrolled = parent.closest(".scroll");
      for (const box of range.getClientRects()) {
        if (!scrolled && (box.left < -0.5 || box.right > document.documentElement.clientWidth + 0.5))
          wrong.push(`${brief(node.textContent)} runs over the edge of the page`);
        if (!scrolled || box.right <= scrolled.getBoundingClientRect().right)
          boxes.push([box.left, box.top, box.right, box.bottom, brief(node.textContent)]);
      }
    }
  }
  // Boxes of lines hold the room between lines, too.
  const inner = boxes.map(([l, t, r, b, text]) => [l + 1, t + 0.25 * (b - t), r - 1, b - 0.25 * (b - t), text]).filter((b) => b[2] > b[0]);
  inner.sort((p, q) => p[1] - q[1]);
  for (let k = 0; k < inner.length; k++) {
    for (let m = k + 1; m < inner.length && inner[m][1] < inner[k][3]; m++) {
      if (inner[k][0] < inner[m][2] && inner[m][0] < inner[k][2]) wrong.push(`${inner[k][4]} and ${inner[m][4]} overlap`);
    }
  }
  const page = document.documentElement;
  if (page.scrollWidth > page.clientWidth) wrong.push(`the page scrolls sideways: ${page.scrollWidth} of ${page.clientWidth} px`);
  return {wrong, count: boxes.length};
})()""".replace("SMALLEST", str(SMALLEST))

# The box of what is shown of the main picture, and the box of its plotting area.
MAP = """(() => {
  const svg = [...document.querySelectorAll("#view .map svg")].find((one) => one.getBoundingClientRect().width > 0);
  if (!svg) return null;
  const box = svg.getBoundingClientRect(), data = JSON.parse(document.getElementById("data").textContent);
  const {area: [l, t, w, h], min, max} = data.placed[svg.classList.contains("page") ? "page" : "phone"];
  const bytes = atob(data.pressure), values = [];
  for (let k = 0; k < bytes.length; k += 2) values.push(bytes.charCodeAt(k) | bytes.charCodeAt(k + 1) << 8);
  const peak = values.indexOf(Math.max(...values)), [nx] = data.shape;
  const x = data.origin[0] + (peak % nx + 0.5) * data.spacing[0], y = data.origin[1] + (Math.floor(peak / nx) + 0.5) * data.spacing[1];
  const plot = [box.left + l * box.width, box.top + t * box.height, w * box.width, h * box.height];
  return {
    picture: [box.left, box.top, box.right, box.bottom], plot, most: data.most, gap: data.gap !== null,
    peak: [plot[0] + (x - min[0]) / (max[0] - min[0]) * plot[2], plot[1] + (max[1] - y) / (max[1] - min[1]) * plot[3]],
  };
})()"""

SAID = 'document.querySelector("#view .said").textContent'
PRESS = 'document.querySelector("#view button[data-view={}]").click()'
# What a canvas shows, as a number that changes with it, and how many of its points have a colour.
CANVAS = """(() => {
  const canvas = document.querySelector("#view canvas"), all = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  let sum = 0, coloured = 0;
  for (let k = 0; k < all.length; k += 4) { sum = (31 * sum + all[k] + 7 * all[k + 1] + 11 * all[k + 3]) % 1000003; coloured += all[k + 3] > 200; }
  return [sum, coloured / (all.length / 4)];
})()"""


def number(text: str) -> float:
    """A number with a prefix of the SI before its unit, as a page writes it."""
    value, _, unit = text.strip().partition(" ")
    powers = {"p": -12, "n": -9, "µ": -6, "m": -3, "k": 3, "M": 6, "G": 9, "T": 12}
    prefixed = len(unit) > 1 and unit not in ("Pa",) and unit[0] in powers
    return float(value) * (10.0 ** powers[unit[0]] if prefixed else 1.0)


def looked_at(browser: Browser, page: Path, shots: Path | None) -> list[str]:
    wrong: list[str] = []
    is_main = 'id="view"' in page.read_text(encoding="utf-8")

    def texts(where: str) -> None:
        found = browser.run(TEXTS)
        wrong.extend(f"{where}: {what}" for what in found["wrong"])
        if found["count"] < 10:
            wrong.append(f"{where}: hardly any text is seen")

    for width, height in SCREENS:
        for scheme in ["light", "dark"]:
            where = f"{width} px, {scheme}"
            browser.open(page, width, height, scheme)
            texts(where)
            if shots:
                browser.shot(shots / f"{page.stem}_{width}_{scheme}.png")
            if is_main:
                wrong.extend(f"{where}: {what}" for what in asked(browser, height, texts, where))
            for event in browser.events:
                kind, what = event.get("method"), event.get("params", {})
                if kind == "Runtime.exceptionThrown" or kind == "Log.entryAdded" and what["entry"]["level"] == "error" \
                        or kind == "Runtime.consoleAPICalled" and what["type"] in ("error", "assert"):
                    wrong.append(f"{where}: on the console: {json.dumps(what)[:300]}")
                if kind == "Network.requestWillBeSent":
                    url = what["request"]["url"]
                    if not url.startswith("data:") and url != page.resolve().as_uri():
                        wrong.append(f"{where}: asks for {url}")

    browser.ask("Emulation.setScriptExecutionDisabled", value=True)
    browser.open(page, *SCREENS[0], "light")
    texts("without scripts")
    there = browser.run("""[document.querySelectorAll("#view .map svg image").length, document.querySelectorAll("table").length,
        document.querySelector("#view .tabs") === null || document.querySelector("#view .tabs").hidden]""")
    if is_main and (there[0] < 1 or not there[2]) or there[1] < 2:
        wrong.append(f"without scripts: pictures, tables, no buttons: {there}")
    browser.ask("Emulation.setScriptExecutionDisabled", value=False)

    browser.open(page, *PAPER, "light", media="print")
    if is_main:
        browser.run('window.dispatchEvent(new Event("beforeprint"))')
        if browser.run(MAP)["picture"][3] > PAPER[1]:
            wrong.append("on paper: the picture is not on the first page")
        if browser.run('document.querySelectorAll("details:not([open])").length'):
            wrong.append("on paper: the scene is folded")
    texts("on paper")
    if len(base64.b64decode(browser.ask("Page.printToPDF", preferCSSPageSize=True)["data"])) < 10_000:
        wrong.append("on paper: there is next to nothing")
    return wrong


def asked(browser: Browser, height: int, texts, where: str) -> list[str]:
    """What is wrong with the answers to a pointer."""
    wrong = []
    main = browser.run(MAP)
    if main is None:
        return ["the main picture is not seen"]
    if main["picture"][3] > height:
        wrong.append(f"the main picture ends at {main['picture'][3]:.0f} of {height} px")
    if browser.run('document.querySelector(".key").getBoundingClientRect().bottom') > height:
        wrong.append("the answer is not on the first screen")
    browser.mouse("mouseMoved", *main["peak"])
    said = browser.run(SAID)
    parts = ["x ", ", y ", ": pressure "] + ([", gap "] if main["gap"] else [])
    if any(part not in said for part in parts):
        wrong.append(f"hover says {said!r}")
    else:
        pressure = number(said.split(": pressure ")[1].split(",")[0])
        base = browser.run('JSON.parse(document.getElementById("data").textContent).units.pressure')
        unit = number("1 " + base) if base in ("MPa", "GPa", "kPa") else 1.0
        # A pixel beside the centre of the strongest cell.
        if not 0.8 < pressure / (main["most"] * unit) < 1.001:
            wrong.append(f"at the peak hover says {said!r}, the largest pressure is {main['most']:g} {base}")
    # A section along a line that is dragged over the map.
    left, top, width, tall = main["plot"]
    browser.drag((left + 0.2 * width, top + 0.3 * tall), (left + 0.8 * width, top + 0.7 * tall))
    if not browser.run('document.querySelectorAll("#view .cut path.pressure").length === 1 && !document.querySelector("#view .cut").hidden'):
        wrong.append("a dragged line gives no section")
    texts(where + ", section")
    browser.run(PRESS.format("surface"))
    before = browser.run(CANVAS)
    box = browser.run('(() => { const b = document.querySelector("#view canvas").getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()')
    middle = (box[0] + 0.5 * box[2], box[1] + 0.5 * box[3])
    browser.drag(middle, (middle[0] + 60, middle[1] - 10))
    after = browser.run(CANVAS)
    if before[1] < 0.02 or after[0] == before[0]:
        wrong.append(f"the surface is not drawn or does not turn: {before}, {after}")
    return wrong


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    options.add_argument("pages", nargs="+", type=Path, metavar="PAGE.html")
    options.add_argument("--shots", type=Path, help="a directory for pictures of what was seen")
    options = options.parse_args()
    if options.shots:
        options.shots.mkdir(parents=True, exist_ok=True)
    browser, failed, started = Browser(), 0, time.monotonic()
    try:
        for page in options.pages:
            wrong = looked_at(browser, page, options.shots)
            failed += len(wrong)
            print(f"{page.stem}: {'as it should be' if not wrong else ''}", flush=True)
            for what in dict.fromkeys(wrong):
                print(f"  {what}")
    finally:
        browser.close()
    print(f"{len(options.pages)} pages, {failed} faults, {time.monotonic() - started:.0f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
