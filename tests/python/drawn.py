"""What the script of a page draws: run by Node.js with a document that has just what scripts ask for."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from typing import Any

import pytest

NODE = shutil.which("node")
node_is_there = pytest.mark.skipif(
    NODE is None, reason="Node.js is not installed: scripts of pages not tested"
)

DOCUMENT = """
const page = JSON.parse(require("fs").readFileSync(0, "utf8"));
const elements = {}, drawn = [];
class Element {
  constructor(text = "") {
    Object.assign(this, { textContent: text, value: "", options: [], listeners: [], hidden: true });
  }
  add(option) {
    this.options.push(option);
    this.value ||= String(option.value);
  }
  addEventListener(_, f) { this.listeners.push(f); }
  append(script) { page.ran ??= script.textContent?.slice(0, 200); }
  insertAdjacentHTML() {}
}
globalThis.document = {
  documentElement: {},
  head: new Element(),
  getElementById: (id) => elements[id] ??= new Element(page.texts[id]),
  createElement: () => new Element(),
  querySelectorAll: () => [],
};
globalThis.getComputedStyle = () => ({ getPropertyValue: (name) => page.colours[name] ?? "" });
globalThis.matchMedia = () => new Element();
globalThis.Option = function (text, value) { return { text, value }; };
globalThis.Plotly = { purge: () => {}, react: (id, data, layout) => drawn.push({ id, data, layout }) };
require("vm").runInThisContext(page.script);
(async () => {
  for (let i = 0; i < 5000 && drawn.length === 0; i++) await new Promise((go) => setTimeout(go, 20));
  for (const [id, value] of page.choices) {
    elements[id].value = value;
    elements[id].listeners.forEach((f) => f());
  }
  const options = {};
  for (const [id, one] of Object.entries(elements)) options[id] = one.options.map(({ text }) => text);
  console.log(JSON.stringify({ drawn, options, ran: page.ran }));
})();
"""


def drawn(page: str, *choices: tuple[str, str]) -> dict[str, Any]:
    """Plots of a page, at first and after each choice; options of its controls; the script that it ran."""
    texts = dict(
        re.findall(r'<script type="application/\w+" id="(\w+)">(.*?)</script>', page, flags=re.DOTALL)
    )
    [script] = re.findall(r"<script>(.*?)</script>", page, flags=re.DOTALL)
    colours = dict(re.findall(r"(--[\w-]+): ([^;]+);", page))
    given = {"texts": texts, "script": script, "colours": colours, "choices": choices}
    assert NODE is not None
    ran = subprocess.run(
        [NODE, "-e", DOCUMENT],
        input=json.dumps(given),
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    result: dict[str, Any] = json.loads(ran.stdout)
    return result
