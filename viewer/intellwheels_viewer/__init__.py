"""The viewer: a web page that shows a run and controls it."""
