"""What a tool does to a surface: depth, evenness, roughness, and the feed that makes them as wanted."""
