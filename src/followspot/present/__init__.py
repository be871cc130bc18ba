"""What a person asks for: pictures, figures, measurements, diagnoses.

Rule of the room: clocks, output files and printed text live here and nowhere below.
"""
