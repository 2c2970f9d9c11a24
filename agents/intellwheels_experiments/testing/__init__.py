"""The pytest fixture, and the worlds under test behind it."""
