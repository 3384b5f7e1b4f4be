"""What a run leaves behind: MCAP files written, read and mended, replayed, exported, shown; live transports."""
