"""The methods of `spherical_conformal_map` as frozen records of their options; no solver is imported here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

from ..angles.effort import Effort
from ..errors import shown
from ..paper.settings import Lai2014
from ..result.method import Method

Gauge = Literal["poles", "centred"]
Polish = Literal["auto", "angles"]


@dataclass(frozen=True, repr=False)
class Auto(Method):
    """The default method: preconditioned Cayley steps, then the repair of folds.

    Parameters
    ----------
    tolerance : float, default 1e-3
        The steps end when the harmonic energy is at most this far above its minimum, in units of the gap between energy
        and flat image area, which is the mesh's own discretisation error.
    max_iterations : int, default 30
        Maximum number of iterations of the minimisation, here steps to the harmonic map.
    backend : str, default "auto"
        Factorisation, see `igl_spheremap.operators.factor.factorize`; "auto" takes the best that is installed.
    gauge : {"poles", "centred"}, default "poles"
        Treatment of limbs whose edges fall below float64's resolution in the centred gauge; maps without such limbs are
        always centred. "poles" uses a Moebius map to take the tips of the three deepest limbs to ends of the
        coordinate axes, where coordinates are finer. "centred" shortens the limbs and keeps the gauge.
    polish : {"auto", "angles"} or None, default "auto"
        Whether Newton steps lower the angle differences of a good map: "auto", if they are predicted to pay; "angles",
        always, for up to 26 times the time, with scipy's factors 50; None, never, so that a good map stays the harmonic
        one.
    effort : Effort, default Effort()
        Cost allowed to steps that lower the angle differences; or a dict of the same names.

    Raises
    ------
    ValueError
        If `gauge` or `polish` is unknown or a number negative or NaN; at the run, if `backend` is unknown.
    TypeError
        If a value is not a number, or `max_iterations` not whole.

    Notes
    -----
    Measurements of the harmonic map decide: the first row of the table that applies. ``result.explain()`` names it.
    "Mean" is the mean size of all angle differences, in degrees.

    =  ==================================================  ========================================================
       measured                                            consequence
    =  ==================================================  ========================================================
    1  more than 1 percent of the faces fold, or the       layouts of the mesh in the plane race in the map's
       degree is not 1                                     place: one, or `Effort.layouts` if the mean is above 2.4
    2  the mean is above 2.4, and the harmonic energy is   the map, repaired where it folds, and `Effort.layouts`
       more than 1.05 times the area of the flat image,    layouts race
       to which conformal maps have it equal
    3  `polish` is "angles"                                steps, until further ones gain less than
                                                           `Effort.polish_gain`
    4  `polish` is "auto", the mean above 1.2, and steps   steps, until further ones gain less than that
       are predicted to lower it by `Effort.price`
    5  faces fold, up to 1 percent                         the map is repaired where it folds
    6  none of this                                        the map stays as it is
    =  ==================================================  ========================================================

    Examples
    --------
    A row each, by stretching a sphere of 642 vertices:

    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.sphere(642)
    >>> def decided(v, **options):
    ...     print(ism.spherical_conformal_map(v, f, **options).explain().splitlines()[0])
    >>> decided(v * [1, 1, 10])
    auto: 100 of 1,280 faces fold, and angles are 9.69 degrees off in the mean; so up to 5 layouts by angles that close
    may start, and steps on angles go on while further ones gain 3.4 percent
    >>> decided(v * [1, 1, 7])
    auto: no face folds, and angles are 3.86 degrees off in the mean; so the map itself and up to 5 layouts by angles
    that close may start, and steps on angles go on while further ones gain 3.4 percent
    >>> decided(v, polish="angles")
    auto: no face folds; so the map itself may start, and steps on angles go on while further ones gain 0.4 percent
    >>> decided(v * [1, 1, 5])
    auto: no face folds, and steps on angles are predicted to pay; so the map itself may start, and steps on angles go
    on while further ones gain 3.4 percent
    >>> dented, (i, j, k) = v.copy(), f[100]
    >>> dented[i] = 3 * v[j] - 2 * v[i]
    >>> decided(dented)
    auto: 2 of 1,280 faces fold, and steps on angles are predicted to gain less than 3.4 percent; so the map is repaired
    where it folds
    >>> decided(v * [1, 1, 3])
    auto: no face folds, and steps on angles are predicted to gain less than 3.4 percent; so the map stays as it is

    Limbs too deep for float64 decide the gauge, or are shortened by a factor:

    >>> results = [ism.spherical_conformal_map(v * [1, 1, 30], f, gauge=gauge) for gauge in ("poles", "centred")]
    >>> [(result.gauge, round(result.stretch, 1)) for result in results]
    [('poles', 1.0), ('centred', 1.5)]
    """

    name: ClassVar[str] = "auto"
    tolerance: float = 1e-3
    max_iterations: int = 30
    backend: str = "auto"
    gauge: Gauge = "poles"
    polish: Polish | None = "auto"
    effort: Effort = Effort()  # noqa: RUF009 - it is frozen

    def __post_init__(self) -> None:
        """Take the effort also as a dict, as files of settings hold it."""
        super().__post_init__()
        if isinstance(self.effort, Mapping):
            object.__setattr__(self, "effort", Effort(**self.effort))
        if not isinstance(self.effort, Effort):
            raise TypeError(
                f"effort is {shown(self.effort)}; give a record such as Effort(systems=5)"
            )


@dataclass(frozen=True, repr=False)
class GuYau(Method):
    """The method "gu-yau": Tutte energy first, then harmonic energy, both by gradient descent with fixed steps.

    Iterates of the Tutte map have round 0, those of the harmonic map round 1.

    Parameters
    ----------
    step : float, default 1.8
        Step size, between 0 and 2, in units of 1 / (sum of the sizes of a vertex's row of the Laplacian).
    tutte : bool, default True
        Whether the Tutte (barycentric) map is made first, as the authors do. Without it the harmonic descent
        starts at the Gauss map, as in the comparisons of Lai et al.
    gradient_tolerance : float, default 1e-3
        The harmonic descent ends when the L2 norm of the tangential gradient without boosts is at most this:
        the rule of `Lai2014`, in the same norm.
    tutte_plateau : float, default 1e-3
        The Tutte map, if it is made, ends when its energy fell by less than this share over 100 iterations: it is a
        start only.
    max_iterations : int, default 20,000
        Maximum number of iterations of each minimisation, one for each of the two maps.
    plateau : float, default 5e-7
        The harmonic descent also ends when its energy fell by less than this share over 100 iterations: the rule of
        `Lai2014`. The authors end by an energy difference, too.

    Raises
    ------
    ValueError
        If the step is not between 0 and 2, a number negative or NaN, or `tutte_plateau` given without `tutte`.
    TypeError
        If a value is not a number, or `max_iterations` not whole.

    References
    ----------
    Gu and Yau 2002, *Computing conformal structures of surfaces*; Gu, Wang, Chan, Thompson, Yau 2004,
    algorithms 1 and 2.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> [r.start for r in ism.spherical_conformal_map(v, f, method=ism.GuYau(tutte=False)).rounds]
    ['gauss map']
    """

    name: ClassVar[str] = "gu-yau"
    step: float = 1.8
    tutte: bool = True
    gradient_tolerance: float = 1e-3
    tutte_plateau: float = 1e-3
    max_iterations: int = 20_000
    plateau: float = 5e-7

    def __post_init__(self) -> None:
        """Refuse steps that diverge, and options of the Tutte map if none is made."""
        super().__post_init__()
        if not self.tutte and "tutte_plateau" in self.settings():
            raise ValueError(
                "tutte_plateau is of the Tutte map, which tutte=False leaves out; drop one of them"
            )
        if not 0 < self.step < 2:
            raise ValueError(
                f"step {self.step:g} is unstable; give one between 0 and 2, in units of what the weights allow"
            )


@dataclass(frozen=True, repr=False)
class Stereographic(Method):
    """The method "stereographic": a conformal map to the plane, then inverse stereographic projection.

    The punctured surface is flattened by one linear solve, reference [11] of Lai et al.

    Parameters
    ----------
    puncture : int, optional
        Face that holds the pole; by default the face with the map of least energy, of four well-shaped ones of middling
        size.
    backend : str, default "auto"
        Factorisation, see `igl_spheremap.operators.factor.factorize`; "auto" takes the best that is installed.

    Raises
    ------
    ValueError
        If `puncture` is negative; at the run, if there is no such face or backend.
    TypeError
        If `puncture` is not whole.
    MapError
        At the run, if the plane map is not finite.

    References
    ----------
    Angenent, Haker, Tannenbaum, Kikinis 1999, *On the Laplace-Beltrami operator and brain surface flattening*.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> ism.spherical_conformal_map(v, f, method=ism.Stereographic(puncture=0)).notes
    ('face 0 is punctured',)
    """

    name: ClassVar[str] = "stereographic"
    puncture: int | None = None
    backend: str = "auto"


#: The class of a method's options, by the name that users give.
METHODS: dict[str, type[Method]] = {
    method.name: method for method in (Auto, Lai2014, GuYau, Stereographic)
}


def method_of(method: str | Method, *kinds: type[Method]) -> Method:
    """The record of options for a method's name or record; a TypeError unless it is of one of `kinds`, if given."""
    taken = kinds
    if not kinds:
        taken = tuple(METHODS.values())
    if isinstance(method, taken):
        return method
    if kinds or not isinstance(method, str):
        names = " or ".join(f"{kind.__name__}()" for kind in taken)
        raise TypeError(f"method is {shown(method)}; give a record of options, such as {names}")
    if method not in METHODS:
        raise ValueError(
            f"unknown method {method!r}: choose one of {', '.join(METHODS)}, or a record of options"
        )
    return METHODS[method]()
