"""What a page must be for everybody: every control has a name and is reached with keys, and all of it has contrast.

The contrasts are those of WCAG 2, level AA: 4.5 for text, 3 for large text and for what shows the focus. Controls that
are disabled are exempt.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from playwright.sync_api import Page

STOPS: Final = 90
"""More presses of the tab key than a page has controls."""

_LIBRARY: Final = """
  const linear = part => part / 255 <= 0.03928 ? part / 255 / 12.92 : ((part / 255 + 0.055) / 1.055) ** 2.4;
  const luminance = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const pen = document.createElement('canvas').getContext('2d', {willReadFrequently: true});
  const colour = text => {
    pen.clearRect(0, 0, 1, 1);
    pen.fillStyle = text;
    pen.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = pen.getImageData(0, 0, 1, 1).data;
    return [r, g, b, a / 255];
  };
  const over = (upper, lower) => [0, 1, 2].map(k => upper[k] * upper[3] + lower[k] * (1 - upper[3]));
  const ground = at => {
    const layers = [];
    for (; at; at = at.parentElement) {
      const layer = colour(getComputedStyle(at).backgroundColor);
      if (layer[3] > 0) layers.push(layer);
      if (layer[3] === 1) break;
    }
    return layers.reverse().reduce((lower, upper) => over(upper, lower), [255, 255, 255]);
  };
  const contrast = (ink, paper) => {
    const [low, high] = [luminance(ink), luminance(paper)].sort((a, b) => a - b);
    return (high + 0.05) / (low + 0.05);
  };
  const seen = at => at.checkVisibility({visibilityProperty: true, opacityProperty: true})
    && at.getBoundingClientRect().width > 1;
  const name = at => (at.getAttribute('aria-label') || (at.labels && at.labels[0] && at.labels[0].innerText)
    || at.innerText || at.title || '').trim();
"""

_FAINT: Final = (
    "() => {"
    + _LIBRARY
    + """
  const found = [], off = 'style,script,title,svg,[disabled],[data-disabled],.mantine-Notification-root';
  const look = (at, text) => {
    if (!text || !seen(at) || at.closest(off)) return;
    const style = getComputedStyle(at), paper = ground(at), ink = colour(style.color);
    for (let one = at; one; one = one.parentElement) ink[3] *= Number(getComputedStyle(one).opacity);
    const size = parseFloat(style.fontSize), large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
    const ratio = contrast(over(ink, paper), paper);
    if (ratio < (large ? 3 : 4.5)) found.push(`${ratio.toFixed(2)} ${style.color} on ${paper}: ${text.slice(0, 40)}`);
  };
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) look(walk.currentNode.parentElement, walk.currentNode.textContent.trim());
  for (const field of document.querySelectorAll('input:not([type=checkbox]),textarea'))
    look(field, field.value || field.placeholder);
  return found;
}"""
)

_BEGIN: Final = """() => {
  document.activeElement.blur();
  window.iwWalked = new Set();
  window.iwUnseen = [];
}"""

# One stop: true once it was there before.
_STOP: Final = (
    "() => {"
    + _LIBRARY
    + """
  const at = document.activeElement;
  if (!at || at === document.body) return false;
  if (window.iwWalked.has(at)) return true;
  window.iwWalked.add(at);
  const style = getComputedStyle(at), ring = style.outlineStyle === 'none' ? 0 : parseFloat(style.outlineWidth);
  // A ring that is inside lies on the control itself.
  const paper = ground(parseFloat(style.outlineOffset) < 0 ? at : at.parentElement);
  const box = at.getBoundingClientRect();
  const inside = box.bottom > 0 && box.right > 0 && box.top < innerHeight && box.left < innerWidth;
  if (ring < 2 || !inside || contrast(colour(style.outlineColor), paper) < 3)
    window.iwUnseen.push(`${name(at)}: ${style.outline} on ${paper}`);
  return false;
}"""
)

_REACHED: Final = (
    "() => {"
    + _LIBRARY
    + """
  const all = document.querySelectorAll('button,input,textarea,select,[role=tab],[role=button]');
  const controls = [...all].filter(at => seen(at) && !at.disabled && at.getAttribute('aria-hidden') !== 'true'
    && !at.closest('.mantine-Notification-root'));
  return {
    reached: controls.filter(at => window.iwWalked.has(at)).map(name),
    missed: controls.filter(at => !window.iwWalked.has(at)).map(name),
    unseen: window.iwUnseen,
  };
}"""
)


class Walk(NamedTuple):
    """A walk through a page with the tab key.

    Attributes:
        reached, missed: The names of the controls that can be used; a control without a name has an empty one.
        unseen: The reached ones whose focus cannot be seen, and why.
    """

    reached: list[str]
    missed: list[str]
    unseen: list[str]


def faint_texts(page: Page) -> list[str]:
    """Return the texts of a page that have too little contrast, with their colours."""
    return [str(text) for text in page.evaluate(_FAINT)]


def walked(page: Page) -> Walk:
    """Press the tab key through the whole page."""
    page.evaluate(_BEGIN)
    for _ in range(STOPS):
        page.keyboard.press("Tab")
        if page.evaluate(_STOP):
            return Walk(**page.evaluate(_REACHED))
    raise AssertionError("the tab key does not come back to the first control")
