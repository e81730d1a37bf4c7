"""What scenes are built with: shapes, textures, lettering, motions, and the builder that collects them."""
