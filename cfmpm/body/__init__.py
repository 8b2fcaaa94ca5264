"""The body: background grid, material points, boundary, loads, cracks."""
