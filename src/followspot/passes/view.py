"""The stages that can be looked at, each from the same camera."""

import enum


class View(enum.StrEnum):
    """What a picture shows. Light (radiance) is displayed with exposure, data as it is."""

    FINAL = "final"
    """Everything together, with sky and blended surfaces."""
    NORMALS = "normals"
    """Interpolated, renormalised world normal as n * 0.5 + 0.5."""
    LAMBERTIAN = "lambertian"
    """The Lambertian coefficients rho alone: texture times constant."""
    SHADING = "shading"
    """All light on surfaces of albedo 1."""
    DIRECT = "direct"
    """Light from the lights times the BSDF, without environment."""
    ENVIRONMENT = "environment"
    """Light from the environment, or what was baked, times the BSDF, without lights."""
    SHADOW = "shadow"
    """How much of the key light reaches the point, 0 to 1; 0 outside its cone."""
    DEPTH = "depth"
    """Distance along the view axis in units; infinite where there is nothing."""
    SHADOW_MAP = "shadow-map"
    """The key light's depth map: distance along its axis in units, as large as a tile; of a point
    light the six sides of a cube, unfolded."""

    @property
    def is_light(self) -> bool:
        """Whether the values are radiance, shown through exposure."""
        return self in (View.FINAL, View.SHADING, View.DIRECT, View.ENVIRONMENT)

    @property
    def metered(self) -> "View":
        """The view that an automatic exposure is measured in: the final one, so that its parts
        compare with it; but surfaces of albedo 1 are brighter than anything in that.
        """
        return View.SHADING if self is View.SHADING else View.FINAL

    @property
    def is_encoded(self) -> bool:
        """Whether the display needs the sRGB curve: linear light or reflectance."""
        return self.is_light or self is View.LAMBERTIAN

    @property
    def has_blended(self) -> bool:
        """Whether blended surfaces are part of it; they have neither one normal nor one depth."""
        return self in (View.FINAL, View.LAMBERTIAN)


SURFACE_VIEWS = tuple(view for view in View if view is not View.SHADOW_MAP)
"""The views that the surface shader writes."""
