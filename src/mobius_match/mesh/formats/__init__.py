"""One module per format: from bytes to a `RawMesh` with the vertex and face numbers of the file.

trimesh reads PLY, STL and glTF, meshio reads VTK; OFF and OBJ are read here. Each module says which errors of its
library it works around. Headers are checked against the size of the file before a library reads it, and libraries are
imported only when a file is read. ``objects`` converts meshes of other libraries.
"""
