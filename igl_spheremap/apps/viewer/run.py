"""A map that is computed while the window goes on."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...descent.iterate import Iterate
from ...descent.recording import Recording
from ...maps.options import Method
from ...maps.sphere_map import SphereMap
from ...maps.spherical_conformal_map import spherical_conformal_map
from ...mesh.check import Mesh, check_mesh

Source = tuple[NDArray[np.float64], NDArray[np.int64]]


class Run:
    """Load a mesh and map it in a thread of its own.

    Parameters
    ----------
    load : callable
        Gives vertices and faces; called in the thread.
    method : str or Method
        As of `spherical_conformal_map`.

    Attributes
    ----------
    mesh : Mesh or None
        The checked source, once it is there.
    recording : Recording or None
        Of the run so far.
    result : SphereMap or None
        Once it is there.
    error : Exception or None
        What ended the run instead.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> run = Run(lambda: ism.samples.make("spheroid", n_vertices=500), "auto")
    >>> run.wait()
    >>> run.result.certificate.folding_free
    True
    """

    def __init__(self, load: Callable[[], Source], method: str | Method) -> None:
        self.mesh: Mesh | None = None
        self.recording: Recording | None = None
        self.result: SphereMap | None = None
        self.error: Exception | None = None
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._work, args=(load, method), daemon=True)
        self._thread.start()

    @property
    def running(self) -> bool:
        """True until there is a result or an error."""
        return self._thread.is_alive()

    def stop(self) -> None:
        """End at the next iterate, with what there is then."""
        self._stopped.set()

    def wait(self) -> None:
        """Until it is done."""
        self._thread.join()

    def _work(self, load: Callable[[], Source], method: str | Method) -> None:
        try:
            v, f = load()
            mesh = check_mesh(v, f)
            recording = Recording(mesh.f)
            self.recording = recording
            self.mesh = mesh  # last: whoever sees the mesh finds the recording

            def listen(iterate: Iterate) -> None:
                recording(iterate)
                if self._stopped.is_set():
                    raise StopIteration

            self.result = spherical_conformal_map(v, f, method, listener=listen)
        except Exception as error:  # shown in the window
            self.error = error
