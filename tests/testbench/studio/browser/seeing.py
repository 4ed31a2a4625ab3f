"""What can be read and named on a page, measured in the browser: contrast as WCAG 2.2 counts it, accessible names."""

from __future__ import annotations

from typing import Any

# Relative luminance and contrast: WCAG 2.2, "relative luminance", "contrast ratio"; AA: success criterion 1.4.3.
CONTRAST = r"""() => {
  const parse = (text) => {
    const found = text.match(/[\d.]+/g)?.map(Number) ?? [0, 0, 0, 0];
    return text.startsWith("color(srgb")
      ? [255 * found[0], 255 * found[1], 255 * found[2], found[3] ?? 1]
      : [found[0], found[1], found[2], found[3] ?? 1];
  };
  const over = ([r, g, b, a], under) => [r, g, b].map((value, i) => a * value + (1 - a) * under[i]);
  const light = (rgb) => {
    const [r, g, b] = rgb.map((v) => v / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ratio = (one, other) => {
    const [low, high] = [light(one), light(other)].sort((a, b) => a - b);
    return (high + 0.05) / (low + 0.05);
  };
  const ancestors = (element) => (element ? [element, ...ancestors(element.parentElement)] : []);
  const shown = (element) => {
    const box = element.getBoundingClientRect();
    const seen = { opacityProperty: true, visibilityProperty: true };
    return box.width > 1 && box.height > 1 && element.checkVisibility(seen);
  };
  const behind = (element) =>
    ancestors(element).reverse().reduce((under, one) => over(parse(getComputedStyle(one).backgroundColor), under),
      [255, 255, 255]);
  const faint = (element) => ancestors(element).reduce((all, one) => all * Number(getComputedStyle(one).opacity), 1);
  const exempt = (element) =>
    element.closest("[disabled], .disabled, [aria-disabled=true], [aria-hidden=true], .q-icon, .cm-gutters");
  const colourOf = (element) => {
    const style = getComputedStyle(element);
    const inked = element.closest("svg") ? style.fill : style.color;
    const [r, g, b, a] = parse(inked);
    return [r, g, b, a * faint(element) * (element.closest("svg") ? Number(style.fillOpacity) : 1)];
  };
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const found = [];
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const element = node.parentElement, text = node.textContent.trim();
    if (!text || element.closest("script, style, noscript") || exempt(element) || !shown(element)) continue;
    const style = getComputedStyle(element);
    const size = parseFloat(style.fontSize), bold = Number(style.fontWeight) >= 700;
    const under = behind(element);
    const seen = ratio(over(colourOf(element), under), under);
    found.push({ text: text.slice(0, 50), ratio: seen, least: size >= 24 || (bold && size >= 18.66) ? 3 : 4.5 });
  }
  return found;
}"""

NAMED = {
    *("button", "link", "textbox", "searchbox", "spinbutton", "combobox", "checkbox", "radio", "switch", "slider"),
    *("tab", "image", "img", "progressbar", "navigation", "region"),
}


def unreadable(page: Any) -> list[str]:
    """Texts whose contrast with what is behind them is below WCAG's AA; disabled controls and icons are exempt."""
    found = page.evaluate(CONTRAST)
    assert found, "there is text on every page"
    return sorted({f"{one['text']!r}: {one['ratio']:.2f}" for one in found if one["ratio"] < one["least"]})


LOOKS = 100  # in 10 s and more; an editor gets its name a moment after it is there


def nameless(page: Any) -> list[str]:
    """Controls and pictures that have no accessible name; Chromium works the names out, as for a screen reader."""
    for _ in range(LOOKS):
        found = _nameless_now(page)
        if not found:
            break
        page.wait_for_timeout(100)
    return found


def _nameless_now(page: Any) -> list[str]:
    session = page.context.new_cdp_session(page)
    nodes = session.send("Accessibility.getFullAXTree")["nodes"]
    session.detach()
    seen = [node for node in nodes if not node["ignored"] and node["role"]["value"] in NAMED]
    assert len(seen) > 5, "there are links on every page"
    return [node["role"]["value"] for node in seen if not node.get("name", {}).get("value", "").strip()]
