"""What a page withholds from somebody who cannot see it, or not well (WCAG 2, AA)."""

import shutil
import subprocess
from pathlib import Path

from conftest import ROOT


def inaccessible(browser):
    """Return what is wrong with the open page: names, alternatives and contrast, and what axe-core finds where npm has it."""
    found = browser.run(ACCESSIBILITY)
    if axe := axe_core():
        browser.run(axe)
        found += browser.run(RUN_AXE)
    return found


def axe_core():
    """The source of axe-core, where npm has installed it here or for everybody; else None."""
    if not (npm := shutil.which("npm")):
        return None
    everybody = subprocess.run(
        [npm, "root", "-g"], capture_output=True, text=True, check=False
    ).stdout.strip()
    paths = [Path(root, "axe-core/axe.min.js") for root in (ROOT / "node_modules", everybody)]
    return next((path.read_text(encoding="utf-8") for path in paths if path.is_file()), None)


RUN_AXE = "return axe.run().then(found => found.violations.map(one => `${one.id}: ${one.nodes[0].html}`))"
ACCESSIBILITY = """
const broken = [], text = e => (e.getAttribute("aria-label") || e.textContent || "").trim();
const name = e => text(e) || [...e.querySelectorAll("img")].map(i => i.alt).join("").trim();
for (const e of document.querySelectorAll("a, button, summary, label, th, h1, h2, h3"))
  if (!name(e)) broken.push(`no name: ${e.outerHTML.slice(0, 200)}`);
for (const e of document.querySelectorAll("img"))
  if (!e.alt && !e.closest("dialog")) broken.push(`no alt: ${e.src.slice(0, 99)}`);
for (const e of document.querySelectorAll("svg")) if (!text(e)) broken.push(`no label: ${e.outerHTML.slice(0, 200)}`);
for (const e of document.querySelectorAll(".wide"))
  if (e.scrollWidth > e.clientWidth && e.tabIndex < 0 && !e.querySelector("button"))
    broken.push(`no keyboard scrolls it: ${e.outerHTML.slice(0, 200)}`);
const colour = text => { const c = text.match(/[\\d.]+/g).map(Number); return c.length < 4 ? [...c, 1] : c; };
const light = c => { const [r, g, b] = c.slice(0, 3).map(v => (v /= 255) <= .04045 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4);
  return .2126 * r + .7152 * g + .0722 * b; };
const behind = e => {
  for (; e; e = e.parentElement) { const c = colour(getComputedStyle(e).backgroundColor); if (c[3] > .99) return c; }
  return [255, 255, 255, 1];
};
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
while (walker.nextNode()) {
  const e = walker.currentNode.parentElement;
  if (!walker.currentNode.textContent.trim() || !e.checkVisibility() || e.closest("script, style, svg")) continue;
  const [a, b] = [light(colour(getComputedStyle(e).color)), light(behind(e))];
  const contrast = (Math.max(a, b) + .05) / (Math.min(a, b) + .05);
  if (contrast < 4.5) broken.push(`contrast ${contrast.toFixed(2)}: ${e.outerHTML.slice(0, 200)}`);
}
return [...new Set(broken)];
"""
