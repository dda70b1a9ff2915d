"""One file a format: each reader turns bytes into a `RawMesh` that keeps the numbers of the user's file.

General mesh libraries read these formats too, but not faithfully to the numbering: trimesh stacks triangles
before quadrilaterals, may split OBJ vertices at texture seams, walks glTF nodes from last to first and
fills compressed geometry with zeros; meshio knows fewer types of PLY and no polygons in VTK files. The
promise here is that every vertex and face number is that of the user's own file, and that a damaged file is
refused quickly.
"""
