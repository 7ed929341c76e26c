"""Exchange with other programs: VTU, RO-Crate, servers of UM-Bridge."""
