"""What every result has: its certificate, the record of its run, and the way to another balance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from ..draw.shown import Shown
from ..errors import check_number, own_errstate
from ..mesh.arrays import FloatArray, IntArray
from ..mesh.timings import timed
from ..verify.certificate import Certificate
from .run import Listener, Round, Run, Status, Step

R = TypeVar("R", bound="Result")
T = TypeVar("T")


class _OfRun(Generic[T]):
    """An attribute of a result that its run has."""

    def __init__(self, doc: str) -> None:
        self.__doc__ = doc

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    @overload
    def __get__(self, result: None, owner: type) -> _OfRun[T]: ...
    @overload
    def __get__(self, result: Result, owner: type) -> T: ...
    def __get__(self, result: Result | None, owner: type) -> _OfRun[T] | T:
        return self if result is None else getattr(result.run, self._name)


class Result(Shown):
    """A map that was made, with its certificate, and how it came about.

    Notebooks show it as a picture of the surface and its image above a table of its figures.

    Attributes
    ----------
    certificate : Certificate
        Of the map's positions, in exact arithmetic.
    run : Run
        How the map came about. What it holds can be read from the result, too: ``result.energy`` is
        ``result.run.energy``.
    """

    if TYPE_CHECKING:  # fields of the records, or properties

        @property
        def certificate(self) -> Certificate: ...
        @property
        def run(self) -> Run: ...
        @property
        def vertices(self) -> FloatArray: ...
        @property
        def faces(self) -> IntArray: ...
        @property
        def _images(self) -> FloatArray: ...

    energy = _OfRun[float]("Harmonic energy, eq. (6): 4 pi for a smooth conformal map; in the plane what was lowered.")
    status = _OfRun[Status]("How the last minimisation ended.")
    iterations = _OfRun[int]("Iterations of all stages together.")
    seconds = _OfRun[float]("Wall seconds from arrays to result.")
    timings = _OfRun[dict[str, float]]("Wall seconds by phase.")
    method = _OfRun[str]("The method's name.")
    settings = _OfRun[dict[str, Any]]("The method's options that are not at their defaults.")
    history = _OfRun[tuple[Step, ...]]("Every iterate of every stage.")
    rounds = _OfRun[tuple[Round, ...]]("Foldings before and after each round of folding removal.")
    backend = _OfRun[str]("The factorisation that was used; empty where none was.")
    notes = _OfRun[tuple[str, ...]]("Remarks on the run, and reasons to doubt the result.")
    gauge = _OfRun[str]("Where the map lies among its Moebius images: centred, turned, poles, given or free, see Run.")
    stretch = _OfRun[float]("Factor by which limbs too deep for float64 are shortened; 1 if there is none.")
    balance = _OfRun[float]("0 for a conformal map, 1 for an area-preserving one.")

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """The images of the vertices, which numpy takes a map for."""
        return np.array(self._images, dtype=dtype, copy=copy)  # None: if needed

    def explain(self) -> str:
        """Say what was decided on the way to the map, and why.

        Returns
        -------
        str
            The method, and the plan of the repair if there was one; a line for each map on the way, with its folded
            faces and its mean angle difference in degrees; and the notes.

        Examples
        --------
        >>> import igl_spheremap as ism
        >>> print(ism.spherical_conformal_map(*ism.samples.make("sphere", n_vertices=500)).explain())
        auto: no face folds, and steps are predicted to gain less than 3 percent; so no steps are taken
        """
        lines = [f"{self.method}: {self.run.plan or self.status.value}"]
        for each in self.rounds:
            collapsed = f"; {each.status.value}" if each.status is Status.COLLAPSED else ""
            lines.append(f"{each.start}: {each.foldings_after:,} folded faces, "
                         f"{each.mean_angle_difference:.3g} degrees off{collapsed}")
        return "\n".join((*lines, *self.notes))

    @own_errstate
    @timed()
    def rebalance(self: R, balance: float, *, listener: Listener | None = None) -> R:
        """Take the map to another balance of the same surface, as a slider does.

        Parameters
        ----------
        balance : float
            0 is conformal, 1 preserves areas, as of the function that made the map. The closer the balances of two
            maps to the sphere or the disk, the fewer steps.
        listener : callable, optional
            Called with every `Iterate`; may raise StopIteration to stop with the current map.

        Returns
        -------
        SphereMap, DiskMap or FlatMap
            Of the same kind. At 0, maps to the sphere and to the disk give the conformal map back that they came from.

        Raises
        ------
        ValueError
            If `balance` is not in [0, 1].
        TypeError
            If it is not a number, or the result is not the map of one surface that has a balance: maps between
            surfaces, and maps to the plane from files.
        FoldingsRemain
            If the map has foldings; `igl_spheremap.repair_foldings` removes those of maps to the sphere.

        Examples
        --------
        >>> import igl_spheremap as ism
        >>> result = ism.balanced_spherical_map(*ism.samples.make("spheroid", n_vertices=1000), balance=0.5)
        >>> result.rebalance(0.6).certificate.folding_free
        True
        """
        return self._rebalanced(check_number(balance, "balance", most=1), listener)

    def _rebalanced(self: R, balance: float, listener: Listener | None) -> R:
        """The map at another balance, which is in range."""
        raise TypeError(f"a {type(self).__name__} can't be rebalanced; make another one, from maps of balance "
                        f"{balance:g} or by a function that takes balance={balance:g}")

    def _size(self) -> str:
        """How large the source is, in words."""
        return f"{len(self.vertices)} vertices, {len(self.faces)} faces"

    def __repr__(self) -> str:
        outcome = "folding-free" if self.certificate.folding_free else f"{self.certificate.foldings} foldings"
        balance = f", balance={self.balance:g}" if self.balance else ""
        return (f"{type(self).__name__}({self._size()}, method={self.method!r}{balance}, {outcome}, "
                f"energy={self.energy:.6f}, {self.status.name}, {self.iterations} iterations, {self.seconds:.2f} s)")
