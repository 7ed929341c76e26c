"""Exchange with other programs: VTU, RO-Crate, decks of CalculiX and Abaqus, UM-Bridge."""
