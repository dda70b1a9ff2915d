"""From matches to maps of whole surfaces, and what is carried along them."""

from .surface_map import SurfaceMap

__all__ = ["SurfaceMap"]
