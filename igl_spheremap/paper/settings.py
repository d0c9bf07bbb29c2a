"""The options of the paper's algorithms: made to work, as printed, as programmed; no solver is imported here."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from ..errors import check_number
from ..result.method import Method

PaperGauge = Literal["centred", "free"]
EdgeWeights = Literal["delaunay", "cotangent"]
PaperMetric = Literal["laplacian", "areas", "vertices"]
#: Which quotient of eq. (12) is the first step tried.
Quotients = Literal["tau_1 first", "tau_2 first", "tau_1", "tau_2"]
#: Source of the rules that the paper's text leaves open.
Rules = Literal["paper", "program"]


@dataclass(frozen=True, repr=False)
class Lai2014(Method):
    """The method "lai2014", the paper's: Algorithm 2 around Algorithm 1, from the Gauss map.

    It has three settings. ``Lai2014()`` is the paper's algorithms made to work, by edge weights that are never
    negative, the Laplacian's own metric, few safeguards, and a repair at the end. `as_printed` is the paper's text to
    the letter. `as_programmed` follows the rules of the program that the paper's reference [18] published.

    Parameters
    ----------
    gradient_tolerance : float, default 1e-3
        Each minimisation ends when the L2 norm of the tangential gradient A F, eq. (9), is at most this, the source
        having unit area. The Gauss map starts between 1e2 and 1e4. On scanned surfaces the rounding of the energy ends
        all progress somewhere between 1e-3 and 1e-6.
    max_iterations : int, default 5000
        Maximum number of iterations of each minimisation, one in each round.
    plateau : float, default 5e-7
        Each minimisation ends, too, when its lowest energy fell by less than this share over the last 100 iterations:
        limbs go on changing for thousands of iterations after the rest has converged.
    rounds : int, default 1
        Maximum number of corrections; 0 is Algorithm 1 alone, whose folds stay. With safeguards a second correction
        removed no foldings on any of 156 bodies.
    rho : float, default 1e-4
        Share of the predicted decrease that a step must reach.
    delta : float, default 0.1
        Factor by which a refused step is shortened.
    xi : float, default 0.85
        Weight of earlier energies in the nonmonotone search: 0 is the monotone Armijo search, 1 averages over
        all iterates.
    tau : float, default 1
        Step that the first iteration tries, the source having unit area.
    bb : {"tau_1 first", "tau_2 first", "tau_1", "tau_2"}, default "tau_1 first"
        Which Barzilai-Borwein quotient of eq. (12) is the step that the next iterations try: the two take turns, or one
        of them alone.
    edge_weights : {"delaunay", "cotangent"}, default "delaunay"
        Weights of the edges in the energy and the eigenproblem. "cotangent" are the paper's, eq. (13), which are
        negative where the angles opposite an edge sum to more than 180 degrees; "delaunay" are those of the intrinsic
        Delaunay triangulation of the surface, which never are.
    metric : {"laplacian", "areas", "vertices"}, default "laplacian"
        Divisor of the energy's derivatives. "areas" are the paper's, eqs. (9) and (13): if vertices are unevenly
        spread, the smallest areas dominate the steps. "laplacian" are the Laplacian's row sums of absolute values,
        which have no scale: Algorithm 1 takes a half to a tenth of the iterations. The tolerance is that of the L2 norm
        in both. "vertices" divides by nothing, and the norm is Frobenius's.
    rules : {"paper", "program"}, default "paper"
        "program" follows the authors' program if the paper says nothing or something else: the fifth trial of a search
        is taken; a quotient of eq. (12) without a value gives way to `tau`, others are kept between 1e-20 and 1e20; and
        a run has converged, too, when map and energy hardly change (`as_programmed`). It has no safeguards, and goes
        with ``may_fold=True, gauge="free"`` only.
    may_fold : bool, default False
        Take steps that fold faces, too, and leave them folded. By default the first minimisation may fold, no later
        step adds foldings to a star map, and remaining folds are repaired.
    gauge : {"centred", "free"}, default "centred"
        "centred" holds the Moebius freedom fixed: starts and drifting maps are centred on the source's area, boosts are
        taken out of the gradient, and the result is turned to the Gauss map. "free" leaves all maps as they come. If
        the gauge is free and the map `may_fold`, there are no safeguards.

    Raises
    ------
    ValueError
        If a choice is unknown, a number negative or NaN, `rho`, `delta` or `xi` not from 0 to 1, or if safeguards are
        asked for with the rules of the program.
    TypeError
        If a value is not a number, a count not whole, or a switch not True or False.
    MapError
        At the run, if a face without area has no cotangent weights.

    References
    ----------
    Lai, Wen, Yin, Gu, Lui 2014, Algorithms 1 and 2.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("dino", n_vertices=1500)
    >>> result = ism.spherical_conformal_map(v, f, method="lai2014")
    >>> [(each.start, each.foldings_before > 0, each.foldings_after) for each in result.rounds][-1]
    ('star map', False, 0)
    >>> result.certificate.folding_free
    True
    """

    name: ClassVar[str] = "lai2014"
    gradient_tolerance: float = 1e-3
    max_iterations: int = 5000
    plateau: float = 5e-7
    rounds: int = 1
    rho: float = 1e-4
    delta: float = 0.1
    xi: float = 0.85
    tau: float = 1.0
    bb: Quotients = "tau_1 first"
    edge_weights: EdgeWeights = "delaunay"
    metric: PaperMetric = "laplacian"
    rules: Rules = "paper"
    may_fold: bool = False
    gauge: PaperGauge = "centred"

    @classmethod
    def as_printed(cls, **options: Any) -> Lai2014:
        """Algorithms 1 and 2 as the paper prints them, without any safeguard.

        It runs the four steps of Algorithm 2 around the six of Algorithm 1, from the Gauss map as it is. A minimisation
        ends when the L2 norm of the tangential gradient A F of eqs. (9) and (13) is at most epsilon = 1e-10, as in the
        paper's tables, or after 5,000 iterations, their most. Double precision hardly ever meets 1e-10, so most runs
        end as MAX_ITERATIONS. Others end as COLLAPSED, at a map to one point, which has the energy 0: coarse meshes do,
        even if the Gauss map has no foldings. The result is not turned or centred: the certificate is of the last
        iteration's very numbers.

        Choices that the paper leaves open are these. The source has unit area, which sets the scale of gradients and
        steps. The first step is 1, and the two quotients of eq. (12) take turns. Rounds end when no folding is left, or
        three are done. Eigenfunctions, given up to an orthogonal matrix, are turned to agree with the map that weights
        them, never inside out. Theorem 2's centre is the mean over dM, as printed; orthogonality to the constants in
        eq. (20) would give the mean over e^{2u} dM, which is 0. If a formula has no value, `docs/equations.md` names
        its substitute, and the notes of a result say how often.

        Parameters
        ----------
        **options
            Options that differ from these.

        Returns
        -------
        Lai2014
            The record.

        Raises
        ------
        ValueError, TypeError
            As of the record.

        Examples
        --------
        >>> import igl_spheremap as ism
        >>> printed = ism.Lai2014.as_printed(rounds=2)
        >>> printed.gradient_tolerance, printed.max_iterations, printed.rounds, printed.may_fold
        (1e-10, 5000, 2, True)
        """
        printed: dict[str, Any] = {
            "gradient_tolerance": 1e-10,
            "plateau": 0.0,
            "rounds": 3,
            "edge_weights": "cotangent",
            "metric": "areas",
            "may_fold": True,
            "gauge": "free",
        }
        return cls(**printed | options)

    @classmethod
    def as_programmed(cls, **options: Any) -> Lai2014:
        """Algorithm 1 by the rules of the authors' published program, and Algorithm 2 around it as printed.

        The program of reference [18] for rows of unit length is OptManiMulitBallGBB of the package OptM by Wen and Yin
        (version 1.0, 2010), whose list of applications names harmonic energy minimization and the paper. It takes
        energies and derivatives from its user; here they are those of eq. (6), H = L F, not divided by areas. All
        products and norms are Frobenius's. The first step is 1e-3, a trial is shortened to a fifth, and the fifth is
        taken. The second quotient of eq. (12) comes first. A run ends when the norm of the tangential gradient is
        below 1e-6; when the map changed by less than 1e-6, in the Frobenius norm over the square root of 3, and the
        energy by less than 1e-12 of 1 + energy; when the means of the last five such changes are below ten times that;
        or after 1,000 iterations.

        Parameters
        ----------
        **options
            As of `as_printed`.

        Returns
        -------
        Lai2014
            The record.

        Examples
        --------
        >>> import igl_spheremap as ism
        >>> v, f = ism.samples.make("spheroid", n_vertices=500)
        >>> ism.algorithm_1(v, f, method=ism.Lai2014.as_programmed()).status.name
        'CONVERGED'
        """
        programmed: dict[str, Any] = {
            "gradient_tolerance": 1e-6,
            "max_iterations": 1000,
            "delta": 0.2,
            "tau": 1e-3,
            "bb": "tau_2 first",
            "metric": "vertices",
            "rules": "program",
        }
        return cls.as_printed(**programmed | options)

    def __post_init__(self) -> None:
        """Refuse search parameters that Algorithm 1 excludes, and safeguards together with the program's rules."""
        super().__post_init__()
        for name in ("rho", "delta", "xi"):
            check_number(getattr(self, name), name, most=1)
        if self.rules == "program" and (not self.may_fold or self.gauge != "free"):
            raise ValueError(
                "the program's rules have no safeguards: they go with may_fold=True and gauge='free', see "
                "Lai2014.as_programmed(), --as-programmed"
            )
