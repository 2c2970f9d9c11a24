"""Panels: what a browser reads and presses beside the scene.

Every file is pure functions (what is seen and chosen in, HTML out) and a thin class that makes the elements in the
container that is open and assigns what changed (viser itself sends nothing for an equal value). Text of a peer goes
through `html.escape`; what a page sends is a stranger's and is checked. Callbacks run in viser's event loop, in the
order of the page's messages: they hand over and return. A panel belongs to one browser: make it on `client.gui`.
"""
