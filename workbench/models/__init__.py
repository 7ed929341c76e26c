"""Reduced models, one file each, and the contract that every model keeps."""
