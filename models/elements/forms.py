"""Weak forms of the straight and the curved beam.

Straight beam (Bernoulli): axial displacement u(s), transverse displacement w(s).
Curved beam: tangential displacement u(s), radial displacement w(s), outward positive; s is the arc
length. The strain is eps = u' + w/R. The change of curvature is kappa = w'' - u'/R ("exact": a
free ring then has its three rigid motions) or kappa = w'' ("shallow").

Coefficients are passed by keyword, with a value for each element or quadrature point: EA [N],
EI [N m2], rho_A [kg/m], tension [N], and for curved beams curvature = 1/R and bend [1/m], the
factor of u' in kappa. The trial functions are u and w, the test functions du and dw. Formulas of
energies are twice the energy per length; in them, test and trial functions are equal.
"""

from typing import Any

from skfem import BilinearForm
from skfem.helpers import d, dd


@BilinearForm  # type: ignore[untyped-decorator]
def straight_stiffness(u: Any, w: Any, du: Any, dw: Any, p: Any) -> Any:
    """Strain energy: E A u'^2 + E I w''^2."""
    return p.EA * d(u)[0] * d(du)[0] + p.EI * dd(w)[0, 0] * dd(dw)[0, 0]


@BilinearForm  # type: ignore[untyped-decorator]
def mass(u: Any, w: Any, du: Any, dw: Any, p: Any) -> Any:
    """Kinetic energy of straight and curved beams: rho A (u^2 + w^2).

    This form is also the energy of a uniform elastic support in both directions.
    """
    return p.rho_A * (u * du + w * dw)


@BilinearForm  # type: ignore[untyped-decorator]
def tension_stiffness(u: Any, w: Any, du: Any, dw: Any, p: Any) -> Any:
    """Energy of an axial force N due to the slope w': N w'^2."""
    return p.tension * d(w)[0] * d(dw)[0]


@BilinearForm  # type: ignore[untyped-decorator]
def coriolis(u: Any, w: Any, du: Any, dw: Any, p: Any) -> Any:
    """Skew form of the Coriolis forces in a rotating frame: rho A (u dw - w du)."""
    return p.rho_A * (u * dw - w * du)


@BilinearForm  # type: ignore[untyped-decorator]
def curved_stiffness(u: Any, w: Any, du: Any, dw: Any, p: Any) -> Any:
    """Strain energy of the curved beam with kappa = w'' - bend u'; bend is 1/R or 0."""
    strain, dstrain = d(u)[0] + p.curvature * w, d(du)[0] + p.curvature * dw
    bending = dd(w)[0, 0] - p.bend * d(u)[0]
    dbending = dd(dw)[0, 0] - p.bend * d(du)[0]
    return p.EA * strain * dstrain + p.EI * bending * dbending
