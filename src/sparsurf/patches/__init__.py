"""Patches around dots, their roughness and their descriptors: functions from arrays to arrays."""
