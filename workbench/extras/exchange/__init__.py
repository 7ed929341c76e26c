"""Exchange with other programs: VTU and RO-Crate."""
