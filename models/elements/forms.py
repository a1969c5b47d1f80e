"""Weak forms of the straight and the curved beam.

Straight beam (Bernoulli): axial displacement u(s), transverse displacement w(s).
Curved beam: tangential displacement u(s), radial displacement w(s), outward positive; with
strain eps = u' + w/R and change of curvature kappa = w'' - u'/R ("exact": a free ring then has
its three rigid motions) or kappa = w'' ("shallow"). s is the arc length.

Coefficients come in by keyword, one value an element: EA [N], EI [N m2], rho_A [kg/m], tension
[N], and for curved beams the curvature 1/R and, in kappa, bend [1/m].
"""

from __future__ import annotations

from typing import Any

from skfem import BilinearForm
from skfem.helpers import d, dd


@BilinearForm  # type: ignore[untyped-decorator]
def straight_stiffness(u: Any, w: Any, du: Any, dw: Any, p: Any) -> Any:
    """Strain energy: E A u'^2 + E I w''^2."""
    return p.EA * d(u)[0] * d(du)[0] + p.EI * dd(w)[0, 0] * dd(dw)[0, 0]


@BilinearForm  # type: ignore[untyped-decorator]
def mass(u: Any, w: Any, du: Any, dw: Any, p: Any) -> Any:
    """Kinetic energy: rho A (u^2 + w^2), the same for straight and curved beams.

    A uniform elastic support in both directions has the same form.
    """
    return p.rho_A * (u * du + w * dw)


@BilinearForm  # type: ignore[untyped-decorator]
def tension_stiffness(u: Any, w: Any, du: Any, dw: Any, p: Any) -> Any:
    """Energy of an axial force N in the slope: N w'^2."""
    return p.tension * d(w)[0] * d(dw)[0]


@BilinearForm  # type: ignore[untyped-decorator]
def coriolis(u: Any, w: Any, du: Any, dw: Any, p: Any) -> Any:
    """Skew power of velocities in a frame that turns: rho A (u dw - w du)."""
    return p.rho_A * (u * dw - w * du)


@BilinearForm  # type: ignore[untyped-decorator]
def curved_stiffness(u: Any, w: Any, du: Any, dw: Any, p: Any) -> Any:
    """Strain energy of the curved beam with kappa = w'' - bend u'; bend is 1/R or 0."""
    strain, dstrain = d(u)[0] + p.curvature * w, d(du)[0] + p.curvature * dw
    bending = dd(w)[0, 0] - p.bend * d(u)[0]
    dbending = dd(dw)[0, 0] - p.bend * d(du)[0]
    return p.EA * strain * dstrain + p.EI * bending * dbending
