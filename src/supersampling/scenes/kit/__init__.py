"""Tools to build scenes with: shapes, textures, lettering, motions, routes and the builder that collects them."""
