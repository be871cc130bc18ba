"""Frozen data in world space: geometry, materials, lights, cameras, sky, visibility.

Rule of the room: no GL, no clocks. Only ``load`` reads files, through ``assets``.
"""
