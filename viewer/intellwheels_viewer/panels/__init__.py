"""Panels: the text and the controls beside the scene.

Every file has pure functions that return HTML for a snapshot and a browser's choices, and a thin class that makes
viser's elements in the open container and assigns what changed (viser sends nothing for an equal value). Text of a peer
goes through `html.escape`. Values from a page are not trusted and are checked. Callbacks run in viser's event loop, in
the order of the page's messages, and must return at once. A panel belongs to one browser: make it on `client.gui`.
"""
