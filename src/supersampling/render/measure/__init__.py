"""Measurements of scenes: motion, disocclusion, lighting, detail, and the cost of buffers."""
