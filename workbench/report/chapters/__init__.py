"""The parts of a report; `report.build.document` says in which order they are read."""
