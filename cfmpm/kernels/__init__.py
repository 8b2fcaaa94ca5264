"""Kernels compiled by Numba: functions from arrays to arrays, without access to scene or body.

Conventions: n nodes, m elements of k nodes, p material points, q materials. Nodes are in mm,
stresses in MPa, volumes in mm^3 per mm of thickness, forces in N per mm of thickness.
"""
