"""The drawings of a run, one per file: pure functions from states to arrays, and a thin class that assigns them.

A class gets a scene, shared or of one browser. It makes each node once and keeps it: viser keeps the messages of
removed nodes until the next browser connects. The caller puts all `show` calls of a tick into one `atomic()` block.
"""
