"""The three clocks, the run loop and their time samples."""
