"""One module a format: bytes in, a `RawMesh` out that keeps the vertex and face numbers of the user's file.

trimesh reads OFF, PLY, STL and glTF, meshio reads VTK; OBJ is read here. Each module says what its library
gets wrong and what is done about it. Headers are checked against the size of the file before a library sees
it, and libraries are imported only when a file is read.
"""
