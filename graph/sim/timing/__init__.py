"""The three clocks, the run loop and what is sampled of them."""
