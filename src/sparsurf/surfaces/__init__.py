"""Molecular surfaces as dots with normals: computed, read and written. This package does not know patches."""

from collections.abc import Callable
from typing import Any

# Returns the module that draws a surface; set by `sparsurf`, since figures and pages are made of surfaces
views: Callable[[], Any]
