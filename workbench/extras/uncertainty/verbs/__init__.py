"""Verbs of uncertain inputs."""
