"""One file a format. Each reader turns bytes into a `RawMesh` that keeps the numbers of the user's file.

OFF, OBJ, PLY, STL and legacy VTK are read here and not by trimesh or meshio: trimesh stacks triangles before
quads and splits OBJ vertices at texture seams, meshio groups faces by size or reads no polygonal VTK at all, and the
promise of this package is that vertex and face numbers are those of the user's own file. glTF (trimesh) and the XML
kind of VTK (meshio) come through faithfully and are left to the libraries.
"""
