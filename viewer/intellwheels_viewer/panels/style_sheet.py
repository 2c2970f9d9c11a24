"""The style sheet of all panels: three font sizes (11 px captions, 13 text, 19 figures) and two themes.

Each panel includes the sheet, because viser mounts only the elements of an open tab. Colours are CSS variables, so the
page alone decides on the theme.
"""

from __future__ import annotations

import html
from collections.abc import Iterable
from typing import Final

_LIGHT: Final = (
    "--iw-ink:#1d232b;--iw-soft:#5a636d;--iw-line:#e2e6eb;--iw-tint:#f3f5f8;--iw-chosen:#fff5bf;"
    "--iw-red:#c4161c;--iw-amber:#9a5b00;--iw-green:#1f7a45;--iw-near:#a0143c;--iw-middle:#a34d07;--iw-far:#3c6a8c;"
    "--iw-wall:#3d4752;--iw-floor:#f4f5f6;--iw-thing:#b9c2cc;--iw-edge:#8a939d;"
    "--iw-focus:#005a9e;--iw-ground:#ffffff"
)
_DARK: Final = (
    "--iw-ink:#e6e9ed;--iw-soft:#a4acb6;--iw-line:#3a4048;--iw-tint:#2c3138;--iw-chosen:#3b350f;"
    "--iw-red:#ff7b78;--iw-amber:#f0ad4e;--iw-green:#62c98d;--iw-near:#ff83a6;--iw-middle:#f3a35c;--iw-far:#92bddd;"
    "--iw-wall:#b4bdc8;--iw-floor:#2a2e34;--iw-thing:#6b7682;--iw-edge:#78828d;"
    "--iw-focus:#7cc0f5;--iw-ground:#242424"
)
# viser's own elements take these colours: with its defaults, captions, buttons and edges of fields have too little
# contrast.
_THEIRS: Final = """
--mantine-color-dimmed:var(--iw-soft);--mantine-color-placeholder:var(--iw-soft);
--mantine-color-gray-text:var(--iw-soft);--mantine-color-gray-light-color:var(--iw-soft);
--mantine-color-default-border:var(--iw-edge);
--mantine-primary-color-filled:var(--iw-focus);--mantine-primary-color-light-color:var(--iw-focus);
--mantine-color-custom-filled:var(--iw-focus);--mantine-color-custom-text:var(--iw-focus);
--mantine-color-custom-outline:var(--iw-focus);--mantine-color-custom-light-color:var(--iw-focus);
--mantine-color-red-text:var(--iw-red);--mantine-color-red-outline:var(--iw-red);
--mantine-color-red-light-color:var(--iw-red);--mantine-color-error:var(--iw-red);
"""
_THEIRS_LIGHT: Final = (
    "--mantine-color-gray-filled:var(--iw-soft);--mantine-color-red-filled:var(--iw-red);"
    "--mantine-color-red-filled-hover:#9c1116;--mantine-color-custom-filled-hover:#004375;"
    "--mantine-primary-color-filled-hover:#004375"
)
# Below the clock there is room for a note (three lines beside the scene), so that nothing moves when one comes. A
# longer note scrolls.
# On the right, text keeps clear of the scrollbar that viser lays over a panel that is longer than the window: 12 px. It
# is made 7 px wide here, because viser's own elements end 9 px before the edge.
# The contrast of every text colour with its background is 4.5 : 1 or more (tests/viewer/panels/test_style_sheet.py).
_RULES: Final = """
.mantine-ScrollArea-root{--scrollarea-scrollbar-size:7px}
.mantine-Input-input:focus-visible{outline:2px solid var(--iw-focus);outline-offset:-1px}
.mantine-Input-input:not(:disabled),.mantine-Checkbox-input:not(:checked):not(:disabled){border-color:var(--iw-edge)}
.iw{box-sizing:border-box;padding:2px 16px 8px 10px;font-size:13px;line-height:18px;color:var(--iw-ink);
font-variant-numeric:tabular-nums;overflow-wrap:anywhere}
.iw *{box-sizing:border-box}.iw b{font-weight:600}
.iw code{font-size:12px;padding:1px 4px;border-radius:3px;background:var(--iw-tint)}
.iw-soft{color:var(--iw-soft)}.iw-small,.iw-caption{font-size:11px;line-height:15px;color:var(--iw-soft)}
.iw-red{color:var(--iw-red)}.iw-amber{color:var(--iw-amber)}.iw-near{color:var(--iw-near)}
.iw-middle{color:var(--iw-middle)}.iw-far{color:var(--iw-far)}
.iw-head{display:flex;align-items:center;gap:7px;min-width:0}
.iw-cut{overflow:hidden;text-overflow:ellipsis;white-space:nowrap;min-width:0}
.iw-dot{flex:none;width:10px;height:10px;border-radius:50%;background:var(--iw-soft)}
.iw-dot.good{background:#2f9e5b}.iw-dot.wait{background:#e08a00}.iw-dot.bad{background:#d6232a}
.iw-figures{display:flex;justify-content:space-between;gap:8px;padding:4px 0 2px}
.iw-figures>div{min-width:0}.iw-figures>div:not(:first-child){text-align:right}
.iw-figure{font-size:19px;line-height:24px;font-weight:500;white-space:nowrap}
.iw-figure.word{font-size:13px;font-weight:600}
.iw table{width:100%;border-collapse:collapse;table-layout:fixed}
.iw th{font-size:11px;line-height:15px;font-weight:400;color:var(--iw-soft);text-align:right;padding:0 0 3px;
vertical-align:bottom}
.iw td{padding:3px 0;text-align:right;vertical-align:top;border-top:1px solid var(--iw-line)}
.iw th:first-child,.iw td:first-child{text-align:left;padding-left:6px}
.iw th:last-child,.iw td:last-child{padding-right:6px}
.iw tr[data-agent]{cursor:pointer}.iw tr[data-agent]:hover td{background:var(--iw-tint)}
.iw tr.chosen td,.iw tr.chosen:hover td{background:var(--iw-chosen)}
.iw tr.chosen td:first-child{box-shadow:inset 3px 0 #e5cf00}
.iw tr.stale td>*,.iw-old,.iw-old b,.iw-old span{color:var(--iw-soft)}.iw tr.stale svg,.iw-old svg{opacity:.4}
.iw-wide{width:min(204px,100cqw - 66px);overflow:hidden;text-overflow:ellipsis;white-space:nowrap}
.iw-wide.iw-whole{width:min(252px,100cqw - 18px)}
.iw-why,.iw th u{cursor:help;text-decoration:underline dotted;text-underline-offset:2px}
.iw-group{padding-top:8px}
.iw-log{list-style:none;margin:0;padding:0}
.iw-log li{display:flex;gap:8px;padding:2px 0;border-top:1px solid var(--iw-line)}
.iw-log li>:first-child{flex:none;min-width:44px;text-align:right;color:var(--iw-soft)}
.iw-log li>:last-child{min-width:0}.iw-log li.break{justify-content:center;color:var(--iw-soft);font-size:11px}
.iw-note{border-left:3px solid var(--iw-soft);background:var(--iw-tint);padding:6px 8px;border-radius:0 4px 4px 0;
margin:2px 0}
.iw-note.bad{border-color:#d6232a}.iw-note.wait{border-color:#e08a00}.iw-note.good{border-color:#2f9e5b}
.iw-over{position:relative;height:0;z-index:2;pointer-events:none}
.iw-over span{position:absolute;right:12px;width:46px;font-size:11px;line-height:12px;white-space:nowrap;
overflow:hidden;text-overflow:ellipsis;font-variant-numeric:tabular-nums}
.iw-plan{position:relative;padding:2px 16px 0 10px}.iw-plan svg{display:block;width:100%;height:auto;overflow:hidden}
.iw-plan.over{height:0;z-index:2;padding-top:2px}.iw-plan [data-agent]{cursor:pointer}
.iw-bar{height:5px;border:solid var(--iw-soft);border-width:0 1px 1px}
div:has(>[data-testid=agents]){max-height:min(44vh,430px);overflow-y:auto;overscroll-behavior:contain;
container-type:inline-size}
:is(div:has(>[data-testid=agents]),.iw-note):focus-visible{outline:2px solid var(--iw-focus);outline-offset:-2px}
.iw tr:has(th) th{position:sticky;top:0;background:var(--iw-ground);z-index:1}
[data-testid=drive],[data-testid=place]{min-height:58px}
[data-testid=clock]{--room:58px;min-height:calc(88px + var(--room))}
[data-testid=clock] .iw-note{max-height:calc(var(--room) - 4px);overflow-y:auto;font-size:12px;line-height:16px;
padding:3px 8px}
.iw-spark{display:block;margin-left:auto}.iw td.iw-word{font-size:11px;color:var(--iw-soft)}
.iw-choice{display:flex;align-items:center;gap:8px;padding-top:3px;padding-bottom:3px;color:var(--iw-soft)}
.iw-choice>span{flex:0 0 auto;min-width:56px}
.iw-segments{flex:1;display:flex;min-width:0;border:1px solid var(--iw-edge);border-radius:6px;overflow:hidden}
.iw-segments button,.iw-tools button{font:inherit;font-size:12px;line-height:16px;color:var(--iw-ink);background:none;
border:0;padding:5px 3px;cursor:pointer;flex:1 1 auto}
.iw-segments button+button{border-left:1px solid var(--iw-line)}
.iw-segments button:hover,.iw-tools button:hover{background:var(--iw-tint)}
.iw-segments button[aria-pressed=true]{background:var(--iw-ink);color:var(--iw-floor);font-weight:600}
.iw-segments button:disabled{color:var(--iw-soft);cursor:not-allowed;opacity:.6}
.iw-segments button:focus-visible,.iw-tools button:focus-visible{outline:2px solid var(--iw-focus);
outline-offset:-2px}
:is(.iw-segments,.iw-tools) button[aria-pressed=true]:focus-visible{outline-color:var(--iw-ground)}
.iw-tools{display:flex;flex-wrap:wrap;gap:5px}.iw:has(>.iw-tools){container-type:inline-size}
@container (max-width:250px){.iw-tools button{flex-basis:30%}}
.iw-tools button{white-space:nowrap;border:1px solid var(--iw-edge);border-radius:6px;padding:5px 2px}
.iw-tools button[aria-pressed=true]{background:var(--iw-red);border-color:var(--iw-red);color:var(--iw-floor)}
.iw-drive{display:flex;gap:12px;align-items:center}
.iw-stick{position:relative;flex:none;width:116px;height:116px;border-radius:50%;touch-action:none;cursor:grab;
background:radial-gradient(circle,transparent 0 13%,var(--iw-tint) 13% 100%);border:1px solid var(--iw-line);
user-select:none}
.iw-stick:active{cursor:grabbing}
.iw-stick u{position:absolute;font-size:11px;line-height:14px;text-decoration:none;color:var(--iw-soft);width:14px;
text-align:center}
.iw-knob{position:absolute;left:37px;top:37px;width:40px;height:40px;border-radius:50%;background:var(--iw-ink);
opacity:.82;pointer-events:none}
.iw-scan{display:grid;grid-template-columns:repeat(3,1fr);gap:6px;padding:4px 0 6px;user-select:none}
.iw-scan .cell{position:relative;min-height:64px;display:flex;align-items:center;justify-content:center;
border-radius:6px;background:var(--iw-tint);overflow:hidden}
.iw-scan .lit,.iw-scan .armed{outline:3px solid var(--iw-ink);outline-offset:-3px;font-weight:600}
.iw-scan .armed{outline-style:dashed}.iw-scan .driving{background:var(--iw-ink);color:var(--iw-floor);font-weight:600}
.iw-scan i{position:absolute;left:0;bottom:0;height:6px;width:100%;background:var(--iw-ink);transform-origin:0 0;
animation:iw-rest linear}
@keyframes iw-rest{from{transform:scaleX(0)}to{transform:scaleX(1)}}
#iw-bar{display:none}
#iw-keys{max-width:min(560px,calc(100vw - 32px));max-height:calc(100dvh - 32px);overflow:auto;
border:1px solid var(--iw-edge);border-radius:8px;padding:16px 20px;background:var(--iw-ground);
color:var(--iw-ink);font-size:13px;line-height:18px}
#iw-keys::backdrop{background:rgba(0,0,0,.4)}
#iw-keys h2{margin:0 0 8px;font-size:19px;line-height:24px}#iw-keys th{text-align:left;padding:3px 16px 3px 0;
vertical-align:top;white-space:nowrap}#iw-keys td{padding:3px 0}#iw-keys p{color:var(--iw-soft)}
#iw-keys form button{font:inherit;min-height:36px;padding:0 16px;border-radius:6px;border:1px solid var(--iw-edge);
background:var(--iw-ink);color:var(--iw-ground);cursor:pointer}
#iw-keys form button:focus-visible,#iw-bar button:focus-visible{outline:3px solid var(--iw-focus);outline-offset:-3px}
@media (max-width:999.98px) and (orientation:portrait),(max-width:575.98px){
#iw-bar{display:flex;position:fixed;z-index:300;left:0;right:0;bottom:0;height:56px;background:var(--iw-ground);
border-top:1px solid var(--iw-edge);padding:0 env(safe-area-inset-right) 0 env(safe-area-inset-left)}
#iw-bar button{flex:1 1 0;min-width:48px;border:0;border-left:1px solid var(--iw-line);background:none;
color:var(--iw-ink);font-size:14px;line-height:18px;font-family:inherit;padding:4px 6px;cursor:pointer}
#iw-bar .iw-now{flex:2 1 0;display:grid;grid-template-columns:auto 1fr;column-gap:8px;align-content:center;
text-align:left;padding-left:14px;border-left:0;font-variant-numeric:tabular-nums}
#iw-bar .iw-now i{grid-row:1/3;align-self:center;font-style:normal;font-size:18px;letter-spacing:-3px;width:24px;
color:var(--iw-amber)}#iw-bar .iw-now i.good{color:var(--iw-green)}#iw-bar .iw-now i.bad{color:var(--iw-red)}
#iw-bar .iw-now b{font-size:16px;font-weight:600}
#iw-bar .iw-now span{font-size:12px;line-height:14px;color:var(--iw-soft)}
#iw-bar button[aria-pressed=true]{background:var(--iw-tint);box-shadow:inset 0 3px var(--iw-focus);font-weight:600}
.iw-stick{width:148px;height:148px}.iw-stick .iw-knob{left:53px;top:53px}.iw-stick u[style]{display:none}
.iw-segments button,.iw-tools button{min-height:40px;font-size:13px}[data-testid=clock]{--room:42px}}
@media (max-height:499.98px){[data-testid=clock]{--room:26px}}
@media (max-width:575.98px){
.mantine-Paper-root[style*="max-height: 60%"]{width:100vw!important;bottom:56px!important;max-height:56dvh!important}
.mantine-Paper-root[style*="max-height: 60%"] [style*="width: 20em"]{width:100vw!important}
body:not([data-iw-open]) .mantine-Paper-root[style*="max-height: 60%"],
body[data-iw-open=""] .mantine-Paper-root[style*="max-height: 60%"]{visibility:hidden;pointer-events:none}}
body:has(#iw-drive-off) .iw-stick{opacity:.5}body:has(#iw-drive-off) .iw-stick{cursor:not-allowed}
"""

STYLE_SHEET: Final = (
    f"<style>:root:root{{{_LIGHT};{_THEIRS}}}:root[data-mantine-color-scheme=light]{{{_THEIRS_LIGHT}}}"
    f":root[data-mantine-color-scheme=dark]{{{_DARK}}}{_RULES}</style>"
)
"""The style element. It has no size."""


def block(name: str, *content: str, classes: str = "") -> str:
    """Return a block of a panel. Tests find it by `data-testid`."""
    return f'<div class="iw {classes}" data-testid="{name}">{"".join(content)}</div>'


def prose(text: str) -> str:
    """Return text as HTML. It is escaped; a part in backquotes becomes code."""
    parts = html.escape(text).split("`")
    return "".join(f"<code>{part}</code>" if index % 2 else part for index, part in enumerate(parts))


def note(text: str, tone: str = "") -> str:
    """Return a highlighted note. The tone is good, wait, bad or empty."""
    return f'<div class="iw-note {tone}">{prose(text)}</div>'


def figures(cells: Iterable[tuple[str, str]]) -> str:
    """Return large figures above their captions.

    Args:
        cells: Each figure, or a word instead, and its caption with the unit.
    """
    return f'<div class="iw-figures">{"".join(_figure(*cell) for cell in cells)}</div>'


def _figure(figure: str, caption: str) -> str:
    # Words and long numbers are set smaller, as they must fit a third of the panel.
    word = " word" if figure.isalpha() or len(figure) > 8 else ""
    return (
        f'<div><div class="iw-figure{word}">{html.escape(figure)}</div>'
        f'<div class="iw-caption">{html.escape(caption)}</div></div>'
    )
