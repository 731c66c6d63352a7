"""Films of a run: its snapshots as moving pictures, as MP4, GIF or WebP."""
