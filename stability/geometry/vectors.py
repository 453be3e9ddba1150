"""Arithmetic of vectors in space, in plain floats: for single vectors many times faster than arrays."""

from math import sqrt

from stability.model import Vec3


def dot(a: Vec3, b: Vec3) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vec3, b: Vec3) -> Vec3:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def add(a: Vec3, b: Vec3) -> Vec3:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def subtract(a: Vec3, b: Vec3) -> Vec3:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def add_scaled(point: Vec3, distance: float, direction: Vec3) -> Vec3:
    return (point[0] + distance * direction[0], point[1] + distance * direction[1], point[2] + distance * direction[2])


def scale(factor: float, a: Vec3) -> Vec3:
    return (factor * a[0], factor * a[1], factor * a[2])


def norm(a: Vec3) -> float:
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


def unit(a: Vec3) -> Vec3:
    return scale(1.0 / norm(a), a)
