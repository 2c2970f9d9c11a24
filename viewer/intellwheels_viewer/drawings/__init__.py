"""What is seen of a run, a file each: a pure function from state to arrays, and a thin class that assigns them.

A class gets a scene (of all browsers, or of one), makes each node once and keeps it: a node that is added and removed
leaves a trace in viser's memory until the next browser comes. The caller puts a tick's `show` calls into one `atomic()`.
"""
