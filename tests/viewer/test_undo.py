"""What can be undone."""

from __future__ import annotations

from intellwheels_schemas.messages import Delete, Position, Teleport
from intellwheels_viewer.undo import DEPTH, UndoStack

MOVE = Teleport(agent="a", position=Position(x=1.0, y=2.0, heading=0.0))


def test_the_newest_change_is_undone_first() -> None:
    stack = UndoStack()
    stack.enter("r")
    stack.push("r", "teleport", MOVE)
    stack.push("r", "delete", Delete(agent="b"))
    assert stack
    assert stack.pop() == ("delete", Delete(agent="b"))
    assert stack.pop() == ("teleport", MOVE)
    assert stack.pop() is None
    assert not stack


def test_changes_of_another_run_cannot_be_undone() -> None:
    stack = UndoStack()
    stack.enter("r")
    stack.push("r", "teleport", MOVE)
    stack.enter("r")
    assert stack
    stack.enter("s")
    stack.push("r", "teleport", MOVE)  # its answer came late
    assert stack.pop() is None


def test_old_changes_are_forgotten() -> None:
    stack = UndoStack()
    stack.enter("r")
    for number in range(DEPTH + 5):
        stack.push("r", "delete", Delete(agent=f"a{number}"))
    found = [stack.pop() for _ in range(DEPTH + 1)]
    assert found[-1] is None
    assert found[-2] == ("delete", Delete(agent="a5"))
