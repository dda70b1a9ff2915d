"""From matches to maps of whole surfaces, and what is carried along them."""

from .quality import Quality, isometric_distance, quality
from .surface_map import SurfaceMap

__all__ = ["Quality", "SurfaceMap", "isometric_distance", "quality"]
