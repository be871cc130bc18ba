"""Frozen data in world space: geometry, materials, lights, cameras, sky, visibility.

Rule of the room: no GL, no clocks. Files are read through ``assets``, when `load` is asked for a
scene; only the TOML of scene files is opened here, by ``scene_file``.
"""
