"""The foldings before and after each iteration: a listener keeps the iterates, and a slider goes through them.

    python demos/every_iteration.py                           # a window
    python demos/every_iteration.py bunny.obj                 # your surface; or sample:bunny
    python demos/every_iteration.py sample:bunny picture.png  # a picture of the last fold; needs no display

Folded faces are red. Both spheres are seen through a lens, a Moebius map that magnifies the largest cluster of them.
"""

import igl_spheremap as ism
from igl_spheremap.apps.demo import run_demo
from igl_spheremap.apps.viewer.body import follow
from igl_spheremap.apps.viewer.colouring import FOLDED_MARKS
from igl_spheremap.apps.viewer.compare import Part, show_parts
from igl_spheremap.draw.plot import fit, pose
from igl_spheremap.result.run import title_of


def every_iteration(v, f, up, target, progress):
    run, turn = ism.Recording(f), pose(v, up)
    show_progress = progress.listener(f)

    def listener(iterate):  # is called with every iterate; the recording keeps them
        run(iterate)
        show_progress(iterate)

    ism.spherical_conformal_map(v, f, method="lai2014", listener=listener)
    progress.close()
    frames = run.frames[1:]  # the first is the Gauss map, which is the start of the iterations, too

    def step(k):  # the surface, and the sphere before and after a step, through a lens
        before, after = frames[k : k + 2]
        folded = before.folded if before.foldings else after.folded
        parts = [Part(f"{len(v):,} vertices", fit(v, turn), f, folded=folded, legend=FOLDED_MARKS)]
        for word, frame in (("before", before), ("after", after)):
            x = frame.iterate.x @ turn.T
            caption = f"{word}: {frame.foldings:,} folded faces\n{title_of(frame.iterate)}"
            parts.append(Part(caption, x, f, folded=frame.folded, lens=follow(x, f, folded), edges=0.5))
        return [parts]

    steps = len(frames) - 1
    last_fold = max((k for k in range(steps) if frames[k].foldings), default=0)
    show_parts(step, target, steps=steps, first=last_fold if target else 0, size=(1200, 560))


if __name__ == "__main__":
    run_demo(every_iteration, "sample:dino:n_vertices=2000")
