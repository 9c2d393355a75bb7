"""Shapes of bodies for kernels: one file for each shape, and one for the choice between shapes.

A file of a shape holds its entry, with the number and the sizes that go into a body's row, and
functions in the body's own frame:

==================  ====================================================  ============
function            answer                                                needed by
==================  ====================================================  ============
``gap``             signed distance of a point, negative inside           all
``gap_of_bone``     distance of a segment, 0 when they meet               all
``long_axis``       longest axis, 0 for shapes as long as wide            all
``from_nearest``    vector from the nearest point, 0 from inside          solids
``inner_radius``    radius of the largest ball about the centre inside    solids
``cut``             cut with the arm's plane, for a pose                  solids
==================  ====================================================  ============

`choice.py` lists the entries and is the only file that branches on a body's shape.
"""
