"""Runs the test cases of an extension of Isaac Sim, installed or unpacked, over the modules of this project."""
