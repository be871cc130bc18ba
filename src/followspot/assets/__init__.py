"""Assets: the bytes and texts of files as arrays and plain records.

The room's rule: byte offsets, dtypes and text grammars live here and nowhere else. Code in
this room takes bytes or text and the name of their source, and returns frozen data as the
file has it: its own units, axes and index order. Files are opened only in `archive` and
in `pak`, for it. The room knows nothing of scenes, GL or the clock, and answers bad input
with one `AssetError`; nothing half-read leaves it.
"""
