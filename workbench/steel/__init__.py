"""Steel, sections and hinges: material, geometry, yield surfaces and their return mapping."""
