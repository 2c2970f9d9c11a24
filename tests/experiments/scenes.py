"""A short scene for batches: a chair with noisy motors drives straight on for two simulated seconds."""

from __future__ import annotations

from pathlib import Path

SCENE = """\
<Scene Format="iw.v1" Name="short" Map="corridor15m" Period="0.05" Pace="lockstep" Miss="strict">
  <Cast Name="chair" Robot="corridor-chair" Mind="{mind}" Place="start">
    <Option Name="MotorNoise" Value="0.1"/>{options}
  </Cast>
  <End>{reach}<Timeout Seconds="2"/></End>
  <Experiment Subject="chair">
    <Factor Name="wheels">
      <Level Name="equal"/>
      <Level Name="unlike"><Setting Agent="chair" Name="WheelRatio" Value="1.02"/></Level>{level}
    </Factor>
    <Compare First="unlike" Second="equal"/>
  </Experiment>
</Scene>
"""
DRIVE = '<Option Name="left" Value="0.5"/><Option Name="right" Value="0.5"/>'
LABORATORY = (
    '<Level Name="real" Real="true"><Bridge Agent="chair"><Option Name="WheelRatio" Value="1.02"/></Bridge></Level>'
)
REACH = '<Reach Agent="chair" Place="goal" Within="14.5"/>'
DIES = '''\
"""Drives, and fails in the third run of its process; the first one is the run in which it joins."""

from intellwheels_agents import Actions

RUNS = []


class Mind:
    def __init__(self, context):
        RUNS.append(context)

    def decide(self, measures):
        if len(RUNS) > 2 and measures.tick == 10:
            raise RuntimeError("failed on purpose")
        return Actions(left_motor=0.5, right_motor=0.5)
'''


def write_scene(folder: Path, *, dies: bool = False, laboratory: bool = False) -> Path:
    """Write the scene and return its path; with `dies`, with a mind that fails in the second run of a worker."""
    (folder / "dies.py").write_text(DIES)
    path = folder / "short.xml"
    mind, options = ("dies.py", "") if dies else ("drive", DRIVE)
    # The laboratory ends before the timeout, so that the two worlds end at different ticks.
    level, reach = (LABORATORY, REACH) if laboratory else ("", "")
    path.write_text(SCENE.format(mind=mind, options=options, level=level, reach=reach))
    return path
