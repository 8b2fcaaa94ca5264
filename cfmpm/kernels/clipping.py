"""Exact intersection of convex polygons with lines and with the triangles of the grid.

Polygons are rows of a buffer, anticlockwise. Their coordinates are taken from a corner nearby:
the difference of two coordinates is exact, so that a body far from the origin loses no digits.
"""

from __future__ import annotations

import numpy as np

from cfmpm._jit import kernel

# Pieces below this part of their triangle are round-off where a domain only touches it.
DUST = 1e-14

# A domain stays whole where a cut would leave less than this part of it, or runs through less than
# this part of its width.
SLIVER = 1e-9


@kernel
def clip(polygon, n, a, b, side, out):
    """Keep the part of a convex polygon on one side of the line through two points.

    Parameters
    ----------
    polygon : (at least n, 2) float
    n : int
        Number of corners; may be 0.
    a, b : (2,) float
    side : float
        1 keeps the left of a -> b, -1 the right; both cut an edge in the same point, to the bit.
    out : (at least 3 n / 2, 2) float
        Overwritten.

    Returns
    -------
    int
        Number of corners of the part, 0 where there is none.
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
    """Return the area of a triangle, positive if anticlockwise."""
    return 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


@kernel
def area_and_centroid(polygon, n):
    """Return area and centroid (area, x, y) of a convex polygon of n >= 1 corners.

    The centroid is a mean with weights that round-off cannot make negative: it lies inside, however
    thin the polygon is.
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
    """Return the bounding boxes (x low, y low, x high, y high) of domains, from their anchors."""
    boxes = np.empty((len(owners), 4))
    for i in range(len(owners)):
        own = vertices[offsets[owners[i]] : offsets[owners[i] + 1]]
        for j in range(2):
            boxes[i, j] = own[:, j].min()
            boxes[i, 2 + j] = own[:, j].max()
    return boxes


@kernel
def clip_domains(nodes, elements, points, weights, changed, anchors, vertices, offsets, owners):
    """Intersect domains with triangles and place quadrature points in the pieces.

    Parameters
    ----------
    nodes : (n, 2) float
    elements : (m, k) int
        Corners first.
    points, weights : (q, 3), (q,) float
        Barycentric rule, for each triangle of a fan over each piece; that of one point, the
        centroid, for the piece as a whole.
    changed : (c,) int
        The triangles.
    anchors, vertices, offsets
        As in `particle_domains.ParticleDomains`.
    owners : (o,) int
        The domains. Every pair is compared by bounding boxes.

    Returns
    -------
    owner, element : (r,) int
        In the order of `changed`, then of `owners`.
    position : (r, 2) float
        [mm].
    volume : (r,) float
        [mm^2].
    """
    boxes = domain_boxes(vertices, offsets, owners)
    # Three cuts of a convex polygon add three corners; where round-off makes it less than convex
    # each may add half of them again.
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
    """Return the largest number of corners of domains."""
    most = 0
    for p in owners:
        most = max(most, offsets[p + 1] - offsets[p])
    return most


@kernel
def of_corners(points):
    """Return the divisors (q,) and the factors (q, 3) by which points follow from the corners.

    A point is the sum of all corners over the divisor, which is one part that all of them have,
    and the rest times each: exact for the rule of three points.
    """
    divisors, rests = np.empty(len(points)), np.empty((len(points), 3))
    for q in range(len(points)):
        least = points[q].min()
        divisors[q] = 1.0 / least
        rests[q] = points[q] - least
    return divisors, rests


@kernel
def give_to_largest(rows, first, lost):
    """Add an area to the largest of the rows from `first` on, where there are any.

    The areas of a triangle's pieces so go on adding up to its own.
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
    """Turn rows of owner, element, x, y and area into arrays."""
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
        [mm].

    Returns
    -------
    (p,) bool
        Whether the segment runs through the domain and its line leaves a part on either side.
    """
    found = np.zeros(len(anchors), np.bool_)
    dx, dy = b[0] - a[0], b[1] - a[1]
    for p in range(len(anchors)):
        own = vertices[offsets[p] : offsets[p + 1]]
        ax, ay = a[0] - anchors[p, 0], a[1] - anchors[p, 1]
        # Where the line enters and leaves, as parts of the way from a to b.
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
