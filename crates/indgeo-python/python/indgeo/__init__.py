"""From scans to CAD: certified projection onto NURBS, inspection, registration and fits, on numpy arrays.

>>> import numpy as np, indgeo
>>> t = np.linspace(0, 1, 200)
>>> fit = indgeo.fit_curve(np.stack([t, np.sin(3 * t)], axis=1), tolerance=1e-3)
>>> fit.ok, fit.max < 1e-3
(True, True)
"""

from . import distributed
from ._command import IndgeoWarning
from ._indgeo import __version__
from .clouds import Cloud, Mesh
from .commands import (
    command,
    fit_curve,
    fit_surface,
    inspect,
    parameterize,
    project,
    read,
    register,
    register_views,
    tessellate,
)
from .results import CurveFit, Inspection, Parameterization, Projection, Registration, Result, SurfaceFit, Views
from .shapes import Curve, Model, Surface

__all__ = [
    "Cloud",
    "Curve",
    "CurveFit",
    "IndgeoWarning",
    "Inspection",
    "Mesh",
    "Model",
    "Parameterization",
    "Projection",
    "Registration",
    "Result",
    "Surface",
    "SurfaceFit",
    "Views",
    "__version__",
    "command",
    "distributed",
    "fit_curve",
    "fit_surface",
    "inspect",
    "parameterize",
    "project",
    "read",
    "register",
    "register_views",
    "tessellate",
]
