"""One HTML page of a recording: clouds, range images, radar, pictures, motion, values, and when everything came."""
