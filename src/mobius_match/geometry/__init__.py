"""Geometry on triangle meshes, thin over libraries: Laplacian, geodesics, eigenfunctions."""
