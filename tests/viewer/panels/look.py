"""Pictures of all panels, light and dark: `python -m tests.viewer.panels.look FOLDER`, from the checkout's top."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from playwright.sync_api import Page

from tests.viewer.panels import made_up
from tests.viewer.panels.board import FAULTS, Board, browser, opened, served


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    seen, choices = made_up.seen(), made_up.choices()
    for theme in ("light", "dark"):
        with served(seen, choices, dark=theme == "dark") as (server, boards), browser() as chromium:
            page = opened(chromium, server)
            board = boards[0]
            for tab in ("Agents", "Drive", "Place", "Layers"):
                page.get_by_role("tab", name=tab).click()
                board.show(seen, replace(choices, placing="Table" if tab == "Place" else None))
                shoot(page, folder / f"{theme}-{tab.lower()}.png")
            page.get_by_role("tab", name="Agents").click()
            page.get_by_role("tab", name="Events").click()
            paused = replace(seen, clock=made_up.clock("paused"), last_tick=3400)
            board.show(paused, replace(choices, selected=None))
            shoot(page, folder / f"{theme}-events-playback.png")
            page.get_by_role("tab", name="Selected").click()
            page.mouse.move(140, 500)
            page.mouse.wheel(0, 4000)
            board.show(seen, choices)
            shoot(page, folder / f"{theme}-sensors.png")
            page.mouse.wheel(0, 9000)
            shoot(page, folder / f"{theme}-sensors-end.png")
            if theme == "light":
                states(page, board, folder)


def states(page: Page, board: Board, folder: Path) -> None:
    for name, empty in {
        "no-router": made_up.nothing("no-router"),
        "no-world": made_up.nothing("no-world"),
        "choose": made_up.nothing("choose", worlds=("lab", "main")),
        "silent": replace(made_up.seen(), phase="silent"),
        "gone": replace(made_up.seen(), phase="gone"),
        "no-agents": replace(made_up.seen(), entities=(), bodies={}, history={}, events=(), measures={}),
    }.items():
        board.show(empty, replace(made_up.choices(), selected=None, allowed=name != "no-agents"))
        shoot(page, folder / f"state-{name}.png")


def shoot(page: Page, path: Path) -> None:
    page.wait_for_timeout(500)  # a picture for people: what is seen, not what is waited for
    page.screenshot(path=path)
    for fault in dict.fromkeys(page.evaluate(FAULTS)):
        print(f"{path.name}: {fault}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
