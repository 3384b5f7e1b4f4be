"""Path followers: a quintic path to a goal, Stanley's steering, and whether the goal is reached."""
