"""Exact intersection of convex polygons (particle domains) with lines and with triangles.

Polygons are rows of a buffer, anticlockwise. Their coordinates are relative to a corner nearby, so
that no digits are lost in a body far from the origin.
"""

from __future__ import annotations

import numpy as np

from cfmpm._jit import kernel

# Intersections with less than this fraction of the area of the triangle are round-off: the domain
# only touches the triangle.
DUST = 1e-14

# A domain is not cut if less than this fraction of its area would be cut off, or if the crack
# segment crosses less than this fraction of its width.
SLIVER = 1e-9


@kernel
def clip(polygon, n, a, b, side, out):
    """Clip a convex polygon by the line through two points (Sutherland and Hodgman 1974).

    Parameters
    ----------
    polygon : (n or more, 2) float
        Corners, anticlockwise [mm].
    n : int
        Number of corners; may be 0.
    a, b : (2,) float
        Points of the line [mm].
    side : float
        1 keeps the part to the left of a -> b, -1 the part to the right; both intersect an edge in
        exactly the same point.
    out : (3 n / 2 or more, 2) float
        Corners of the part that is kept; overwritten [mm].

    Returns
    -------
    int
        Number of corners of the part; 0 if it is empty.
    """
    if n == 0:
        return 0
    dx, dy = b[0] - a[0], b[1] - a[1]
    count = 0
    px, py = polygon[n - 1, 0], polygon[n - 1, 1]
    before = side * (dx * (py - a[1]) - dy * (px - a[0]))
    for i in range(n):
        x, y = polygon[i, 0], polygon[i, 1]
        here = side * (dx * (y - a[1]) - dy * (x - a[0]))
        if before < 0.0 < here or here < 0.0 < before:
            t = before / (before - here)
            out[count, 0] = px + t * (x - px)
            out[count, 1] = py + t * (y - py)
            count += 1
        if here >= 0.0:
            out[count, 0] = x
            out[count, 1] = y
            count += 1
        px, py, before = x, y, here
    return count


@kernel
def triangle_area(a, b, c):
    """Return the area of a triangle with corners a, b, c [mm^2], positive if anticlockwise."""
    return 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


@kernel
def area_and_centroid(polygon, n):
    """Return area and centroid of a convex polygon.

    Parameters
    ----------
    polygon : (n or more, 2) float
        Corners, anticlockwise [mm].
    n : int
        Number of corners, at least 1.

    Returns
    -------
    area : float
        [mm^2].
    x, y : float
        Centroid [mm]. Its weights are not negative in spite of round-off, so that it lies inside
        the polygon even if this is thin.
    """
    area = x = y = 0.0
    for i in range(1, n - 1):
        part = max(triangle_area(polygon[0], polygon[i], polygon[i + 1]), 0.0)
        area += part
        x += part * (polygon[i, 0] + polygon[i + 1, 0] - 2.0 * polygon[0, 0])
        y += part * (polygon[i, 1] + polygon[i + 1, 1] - 2.0 * polygon[0, 1])
    scale = 1.0 / (3.0 * area) if area > 0.0 else 0.0
    return area, polygon[0, 0] + scale * x, polygon[0, 1] + scale * y


@kernel
def domain_boxes(vertices, offsets, owners):
    """Return the bounding boxes of domains relative to their anchors, (o, 4) [mm].

    Columns: smallest x, smallest y, largest x, largest y. Arguments as in `clip_domains`.
    """
    boxes = np.empty((len(owners), 4))
    for i in range(len(owners)):
        own = vertices[offsets[owners[i]] : offsets[owners[i] + 1]]
        for j in range(2):
            boxes[i, j] = own[:, j].min()
            boxes[i, 2 + j] = own[:, j].max()
    return boxes


@kernel
def clip_domains(nodes, elements, points, weights, changed, anchors, vertices, offsets, owners):
    """Intersect domains with triangles, and place quadrature points in the intersections.

    Parameters
    ----------
    nodes : (n, 2) float
        [mm].
    elements : (m, k) int
        Nodes of each element, the three corners first.
    points, weights : (q, 3), (q,) float
        Quadrature rule in area coordinates. An intersection is divided into a fan of triangles,
        each with this rule; a rule of one point is applied to the intersection as a whole, at its
        centroid.
    changed, owners : (c,), (o,) int
        Triangles and domains to intersect; bounding boxes exclude most of the c o pairs.
    anchors, vertices, offsets
        As in `particle_domains.ParticleDomains`.

    Returns
    -------
    owner, element : (r,) int
        Domain and triangle of each quadrature point, in the order of `changed`, then of `owners`.
    position : (r, 2) float
        [mm].
    volume : (r,) float
        Volume per mm of thickness [mm^2].
    """
    boxes = domain_boxes(vertices, offsets, owners)
    # Clipping by three sides adds three corners to a convex polygon. If round-off makes it slightly
    # non-convex, each clip adds at most half the number of corners: 1.5^3 < 4.
    widest = 4 * most_corners(offsets, owners)
    piece, work = np.empty((widest, 2)), np.empty((widest, 2))
    corners = np.zeros((3, 2))
    parts, rests = of_corners(points)
    whole = weights.sum()
    rows = []
    for e in changed:
        origin = nodes[elements[e, 0]]
        for k in range(1, 3):
            corners[k] = nodes[elements[e, k]] - origin
        dust = DUST * triangle_area(corners[0], corners[1], corners[2])
        low_x, high_x = corners[:, 0].min(), corners[:, 0].max()
        low_y, high_y = corners[:, 1].min(), corners[:, 1].max()
        first = len(rows)
        lost = 0.0
        for i in range(len(owners)):
            p = owners[i]
            x, y = anchors[p, 0] - origin[0], anchors[p, 1] - origin[1]
            if x + boxes[i, 0] > high_x or x + boxes[i, 2] < low_x:
                continue
            if y + boxes[i, 1] > high_y or y + boxes[i, 3] < low_y:
                continue
            n = offsets[p + 1] - offsets[p]
            for j in range(n):
                piece[j, 0] = vertices[offsets[p] + j, 0] + x
                piece[j, 1] = vertices[offsets[p] + j, 1] + y
            for k in range(3):
                n = clip(piece, n, corners[k], corners[(k + 1) % 3], 1.0, work)
                piece, work = work, piece
            if len(points) == 1:
                area, x, y = area_and_centroid(piece, n)
                if area > dust:
                    rows.append((p, e, x + origin[0], y + origin[1], area))
                else:
                    lost += area
                continue
            for j in range(1, n - 1):
                a, b, c = piece[0], piece[j], piece[j + 1]
                area = triangle_area(a, b, c)
                if area <= dust:
                    lost += area
                    continue
                sum_x, sum_y = a[0] + b[0] + c[0], a[1] + b[1] + c[1]
                for q in range(len(points)):
                    ra, rb, rc = rests[q, 0], rests[q, 1], rests[q, 2]
                    x = sum_x / parts[q] + (ra * a[0] + rb * b[0] + rc * c[0])
                    y = sum_y / parts[q] + (ra * a[1] + rb * b[1] + rc * c[1])
                    rows.append((p, e, x + origin[0], y + origin[1], area * weights[q] / whole))
        give_to_largest(rows, first, lost)
    return as_columns(rows)


@kernel
def most_corners(offsets, owners):
    """Return the largest number of corners of the domains `owners`."""
    most = 0
    for p in owners:
        most = max(most, offsets[p + 1] - offsets[p])
    return most


@kernel
def of_corners(points):
    """Return the coefficients from which quadrature points are computed with least round-off.

    A point is the sum of the corners divided by its divisor, plus the sum of the corners times
    their factors. For the rule of three points the factors are 0 and 1/2, which are exact.

    Parameters
    ----------
    points : (q, 3) float
        Quadrature points in area coordinates.

    Returns
    -------
    divisors : (q,) float
        Inverse of the smallest area coordinate.
    rests : (q, 3) float
        Area coordinates less the smallest one.
    """
    divisors, rests = np.empty(len(points)), np.empty((len(points), 3))
    for q in range(len(points)):
        least = points[q].min()
        divisors[q] = 1.0 / least
        rests[q] = points[q] - least
    return divisors, rests


@kernel
def give_to_largest(rows, first, lost):
    """Add an area to the row with the largest area, among the rows from `first` on.

    The area of neglected intersections is thus kept in the sum over the triangle.
    """
    if len(rows) == first:
        return
    largest = first
    for row in range(first, len(rows)):
        if rows[row][4] > rows[largest][4]:
            largest = row
    p, e, x, y, area = rows[largest]
    rows[largest] = (p, e, x, y, area + lost)


@kernel
def as_columns(rows):
    """Return rows of owner, element, x, y, area as the arrays of `clip_domains`."""
    owner, element = np.empty(len(rows), np.int64), np.empty(len(rows), np.int64)
    position, volume = np.empty((len(rows), 2)), np.empty(len(rows))
    for row in range(len(rows)):
        owner[row], element[row], position[row, 0], position[row, 1], volume[row] = rows[row]
    return owner, element, position, volume


@kernel
def find_cut_domains(anchors, vertices, offsets, a, b):
    """Find the domains that the segment from a to b cuts in two.

    Parameters
    ----------
    anchors, vertices, offsets
        As in `particle_domains.ParticleDomains`.
    a, b : (2,) float
        Ends of the crack segment [mm].

    Returns
    -------
    (p,) bool
        Whether the segment crosses the domain and both parts exceed the fraction `SLIVER`.
    """
    found = np.zeros(len(anchors), np.bool_)
    dx, dy = b[0] - a[0], b[1] - a[1]
    for p in range(len(anchors)):
        own = vertices[offsets[p] : offsets[p + 1]]
        ax, ay = a[0] - anchors[p, 0], a[1] - anchors[p, 1]
        # Parameters from 0 at a to 1 at b at which the line enters and leaves the domain.
        enter, leave = np.inf, -np.inf
        px, py = own[-1, 0] - ax, own[-1, 1] - ay
        before = dx * py - dy * px
        for i in range(len(own)):
            x, y = own[i, 0] - ax, own[i, 1] - ay
            here = dx * y - dy * x
            if (before < 0.0) != (here < 0.0):
                t = before / (before - here)
                along = dx * (px + t * (x - px)) + dy * (py + t * (y - py))
                at = along / (dx * dx + dy * dy)
                enter, leave = min(enter, at), max(leave, at)
            px, py, before = x, y, here
        if min(leave, 1.0) - max(enter, 0.0) <= SLIVER * (leave - enter):
            continue
        start = np.array([ax, ay])
        work = np.empty((2 * len(own), 2))
        n = clip(own, len(own), start, np.array([ax + dx, ay + dy]), 1.0, work)
        part = area_and_centroid(work, n)[0] / area_and_centroid(own, len(own))[0]
        found[p] = SLIVER < part < 1.0 - SLIVER
    return found
