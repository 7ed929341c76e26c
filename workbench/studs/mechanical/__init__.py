"""Mechanical model of a stud: fiber beam on bearing concrete with anchorage."""
