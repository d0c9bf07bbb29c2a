"""Cost of a window to a run: frames and iterates a second, with the player's window live, and without drawing.

python -m benchmarks player [--vertices 200000] [--seconds 8]      # needs a display; `xvfb-run` makes one
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import polyscope as ps

import igl_spheremap as ism
from igl_spheremap.apps.viewer import app, window
from igl_spheremap.apps.viewer import background_run as runs
from igl_spheremap.apps.viewer.choices import Pictures
from igl_spheremap.apps.viewer.player import Player, in_background
from igl_spheremap.maps.options import METHODS
from igl_spheremap.result.recording import BUDGET
from igl_spheremap.samples import from_spec

from .common import parser


@dataclass(frozen=True)
class Load:
    """Loads a sample in the process of the run, and has each of its iterates write the time into a file."""

    clock: Path

    def __call__(self, name: str) -> runs.Source:
        send, clock = runs._Sender.__call__, self.clock.open("ab", buffering=0)

        def timed(sender: runs._Sender, iterate: ism.Iterate) -> None:
            clock.write(np.float64(time.monotonic()).tobytes())
            send(sender, iterate)

        runs._Sender.__call__ = timed
        return from_spec(name)


def frames(callback: Callable[[], None], seconds: float) -> list[float]:
    """Run the window, and return the times of its frames."""
    times = [time.monotonic()]

    def tick() -> None:
        times.append(time.monotonic())
        if times[-1] - times[0] > seconds:
            ps.unshow()
        callback()

    ps.set_user_callback(tick)
    ps.show()
    return times


def main(argv: list[str]) -> None:
    """Print the figures."""
    arguments = parser(__doc__)
    arguments.add_argument("--vertices", type=int, default=10_000)
    arguments.add_argument("--seconds", type=float, default=4.0)
    arguments.add_argument("--cycles", type=int, default=3)
    args = arguments.parse_args(argv)
    app.open_for(Pictures(size=(1400, 560)))
    name = f"dino:n_vertices={args.vertices}"
    v, f = from_spec(name)
    bodies = [ps.register_surface_mesh(str(k), 0.01 * v + [k, 0, 0], f) for k in range(3)]
    ps.set_max_fps(-1)
    times = frames(lambda: bodies[0].update_vertex_positions(0.01 * v), args.seconds)
    print(
        f"polyscope alone, three meshes, one of them moving: {len(times) / args.seconds:.1f} frames/s"
    )
    ps.remove_all_structures()
    ps.set_max_fps(window.MAX_FPS)
    with tempfile.TemporaryDirectory() as folder:
        clock = Path(folder) / "clock"
        method = METHODS["lai2014"](gradient_tolerance=1e-14, plateau=0.0, max_iterations=10**6)
        player = Player(partial(in_background, Load(clock), BUDGET), name, method)
        while len(player.run.frames) < 3:
            player.tick()
            time.sleep(0.01)
        for _ in range(args.cycles):
            live = np.array(frames(lambda: app._live(player), args.seconds))
            taken = time.monotonic()
            while time.monotonic() < taken + args.seconds:
                player.run.poll(seconds=0.1, wait=0.1)
            iterates = np.fromfile(clock)
            rates = [
                ((iterates > begin) & (iterates < begin + args.seconds)).sum() / args.seconds
                for begin in (live[0], taken)
            ]
            print(
                f"{len(live) / (live[-1] - live[0]):.1f} frames/s, longest {np.diff(live).max():.2f} s; "
                f"{rates[0]:.1f} iterates/s, {rates[1]:.1f} without drawing: {rates[0] / rates[1]:.0%}"
            )
        player.close()
