"""What a scene shows, in numbers: motion, disocclusion, lighting, detail, and what its buffers cost."""
