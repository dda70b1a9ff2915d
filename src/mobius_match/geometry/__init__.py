"""Geometry of triangle meshes on plain arrays: Laplacian, geodesics, curvature, eigenfunctions, nearest neighbours."""
